#!/usr/bin/env python3
"""Flash, RAM and worst stack of a Cortex-M image: sizes from the linker, stack from -fstack-usage along the call graph.

The deepest path from main() plus the deepest interrupt on top of it. Calls are read from the disassembly; a cycle
(recursion) or an indirect call is reported and fails. Library functions without a .su file are measured by what their
code pushes.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

EXCEPTION_FRAME = 32 + 4  # eight registers that the processor saves, and alignment
HANDLERS = ("systick_handler", "uart0_rx_handler", "uart0_tx_handler")


def run(*command: str) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def frames(folder: Path) -> dict[str, int]:
    """Bytes of stack of each compiled function."""
    found: dict[str, int] = {}
    for path in folder.glob("*.su"):
        for line in path.read_text(encoding="utf-8").splitlines():
            place, size, kind = line.split("\t")
            if kind != "static":
                sys.exit(f"{place}: stack of no fixed size ({kind})")
            name = place.rsplit(":", 1)[1]
            found[name] = max(found.get(name, 0), int(size))
    return found


def base(name: str) -> str:
    """Without what the optimiser adds: .constprop.0, .part.0, .isra.0."""
    return name.split(".", 1)[0]


def calls(disassembly: str) -> tuple[dict[str, set[str]], dict[str, int], set[str]]:
    """Who calls whom; what a function without a .su file pushes; who calls through a pointer."""
    graph: dict[str, set[str]] = defaultdict(set)
    pushed: dict[str, int] = defaultdict(int)
    indirect: set[str] = set()
    function = ""
    for line in disassembly.splitlines():
        head = re.match(r"[0-9a-f]+ <([^>]+)>:$", line)
        if head:
            function = head.group(1)
            graph[function]
            continue
        parts = line.split("\t")
        if len(parts) < 3:
            continue
        operation, operands = parts[2].strip(), parts[3] if len(parts) > 3 else ""
        target = re.search(r"<([^>+]+)>", operands)
        jumps = re.match(r"(bl|b|b[a-z]{2}|cbz|cbnz)(\.[nw])?$", operation)
        if jumps and target and target.group(1) != function:
            graph[function].add(target.group(1))
        elif operation == "bl" and target and target.group(1) == function:
            graph[function].add(function)
        elif operation == "blx" and not target:
            indirect.add(function)
        if re.match(r"(push|stmdb|vpush)", operation) and (operation.startswith("push") or "sp!" in operands):
            names = operands[operands.index("{") + 1 : operands.index("}")]
            for name in names.split(","):
                ends = [int(n) for n in re.findall(r"\d+", name)]
                pushed[function] += 4 * (ends[1] - ends[0] + 1 if "-" in name and len(ends) == 2 else 1)
        subtracted = re.match(r"sp, (?:sp, )?#(\d+)", operands)
        if operation.startswith("sub") and subtracted:
            pushed[function] += int(subtracted.group(1))
        saved = re.search(r"\[sp, #-(\d+)\]!", operands)
        if operation.startswith("str") and saved:
            pushed[function] += int(saved.group(1))
    return graph, pushed, indirect


def deepest(graph: dict[str, set[str]], cost: dict[str, int], start: str) -> tuple[int, list[str]]:
    """Bytes and path of the deepest chain of calls. Ends the program where there is a cycle."""
    known: dict[str, tuple[int, list[str]]] = {}

    def visit(name: str, above: tuple[str, ...]) -> tuple[int, list[str]]:
        if name in above:
            sys.exit(f"recursion: {' -> '.join((*above, name))}")
        if name not in known:
            below = max((visit(callee, (*above, name)) for callee in graph[name]), default=(0, []))
            known[name] = (cost[name] + below[0], [name, *below[1]])
        return known[name]

    return visit(start, ())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("image", type=Path)
    parser.add_argument("folder", type=Path, help="where the .su files are")
    parser.add_argument("--cross", default="arm-none-eabi-")
    options = parser.parse_args()
    sizes = run(f"{options.cross}size", "-A", str(options.image))
    section = {m[1]: int(m[2]) for m in re.finditer(r"^(\.\S+)\s+(\d+)", sizes, re.MULTILINE)}
    flash = section.get(".text", 0) + section.get(".ARM.exidx", 0) + section.get(".data", 0)
    ram = section.get(".data", 0) + section.get(".bss", 0) + section.get(".noinit", 0)

    graph, pushed, indirect = calls(run(f"{options.cross}objdump", "-d", str(options.image)))
    compiled = frames(options.folder)
    cost = {
        name: max(compiled.get(base(name), 0), 0 if base(name) in compiled else pushed[name])
        for name in graph
    }
    reached = deepest(graph, cost, "main")
    if indirect & set(graph):
        sys.exit(f"calls through a pointer: {', '.join(sorted(indirect))}")
    interrupt = max(deepest(graph, cost, name)[0] for name in HANDLERS if name in graph) + EXCEPTION_FRAME
    core = sum(
        int(line.split()[0]) + int(line.split()[1])
        for path in options.folder.glob("*.o")
        if path.stem not in ("main", "startup", "simulated_joints", "snakebot")
        for line in run(f"{options.cross}size", str(path)).splitlines()[1:]
    )
    print(f"flash {flash} bytes (core without the generated codec and libraries: {core}), RAM {ram} bytes")
    print(
        f"worst stack {reached[0] + interrupt} bytes: {reached[0]} below main, {interrupt} for an interrupt on top"
    )
    print("deepest: " + " -> ".join(reached[1]))


if __name__ == "__main__":
    main()
