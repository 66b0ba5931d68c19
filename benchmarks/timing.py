"""How long something takes, and on what machine."""

import os
import platform
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np


def best(function: Callable[[], object], repeats: int = 15, calls: int = 20) -> float:
    """Seconds a call, the best of several repeats."""
    function()
    found = np.inf
    for _ in range(repeats):
        start = time.perf_counter()
        for _ in range(calls):
            function()
        found = min(found, (time.perf_counter() - start) / calls)
    return float(found)


def median(function: Callable[[], object], calls: int = 20_000) -> float:
    times = np.empty(calls)
    for i in range(calls):
        start = time.perf_counter()
        function()
        times[i] = time.perf_counter() - start
    return float(np.median(times))


def machine() -> str:
    model = platform.processor()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        lines = [s for s in cpuinfo.read_text().splitlines() if s.startswith("model name")]
        model = lines[0].partition(":")[2].strip() if lines else model
    return f"{model}, {os.cpu_count()} cores, Python {platform.python_version()}"
