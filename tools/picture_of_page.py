#!/usr/bin/env python3
"""Take the picture of the live page, docs/view.png, in Chromium, of a run on the simulated board."""

from __future__ import annotations

import argparse
import os
import tempfile
from pathlib import Path

from bench_view import chromium, served

ROOT = Path(__file__).resolve().parent.parent
WAVE = ["--alpha", "50", "--beta", "70", "--omega", "2.5", "--duration", "60"]
SHOWN_S = 13.0  # into the run


def main() -> None:
    argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    ).parse_args()
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        os.chdir(folder)  # the page shows the log's path
        with served(
            "run", *WAVE, "--log", "runs/run.mcap", "--fault", "free:4@8s", "--view", "--view-port", "0"
        ) as (
            _,
            url,
        ):
            page = browser.new_page(viewport={"width": 1280, "height": 900})
            page.goto(url)
            page.wait_for_timeout(1e3 * SHOWN_S)
            page.screenshot(path=ROOT / "docs" / "view.png")


if __name__ == "__main__":
    main()
