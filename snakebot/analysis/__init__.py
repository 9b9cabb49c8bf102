"""What runs say: tracking, sines, steady state, speed, power, link; of one run, of several, of one beside its
simulation.

Names load on first use, so that a command that needs none of it pays for none of it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.lazy import names_from

if TYPE_CHECKING:
    from snakebot.analysis.comparison import Comparison, compare
    from snakebot.analysis.joints import JointAnalysis, analyze_joint
    from snakebot.analysis.loading import Loaded, load, load_one
    from snakebot.analysis.run_analysis import RunAnalysis, analyze_run
    from snakebot.analysis.tables import PaperTables, paper_tables

_HOME = {
    "Comparison": "comparison",
    "JointAnalysis": "joints",
    "Loaded": "loading",
    "PaperTables": "tables",
    "RunAnalysis": "run_analysis",
    "analyze_joint": "joints",
    "analyze_run": "run_analysis",
    "compare": "comparison",
    "load": "loading",
    "load_one": "loading",
    "paper_tables": "tables",
}

__all__ = [
    "Comparison",
    "JointAnalysis",
    "Loaded",
    "PaperTables",
    "RunAnalysis",
    "analyze_joint",
    "analyze_run",
    "compare",
    "load",
    "load_one",
    "paper_tables",
]

__getattr__ = names_from(__name__, _HOME)
