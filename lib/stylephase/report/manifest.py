"""What a set of numbers was made with: code, data, versions and machine."""

import hashlib
import os
import platform
import time
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path
from typing import Any

import psutil

from stylephase.files import sha256

ROOT = Path(__file__).resolve().parents[3]
PACKAGES = ("stylephase", "numpy", "scipy", "torch", "scikit-learn", "matplotlib", "pyvista", "papermill")


def manifest(
    *, notebook: str, dataset: str, preset: str, params: dict[str, Any], data_files: Iterable[Path], root: Path = ROOT
) -> dict[str, Any]:
    """The manifest of a notebook's numbers: all that they depend on, and the seconds since its process began."""
    sources = [*sorted((root / "lib" / "stylephase").rglob("*.py")), root / "notebooks" / f"{notebook}.py"]
    return {
        "dataset": dataset,
        "preset": preset,
        "params": params,
        "code_hash": combined_hash(sources, root),
        "data_hash": combined_hash(data_files, root),
        "versions": versions(),
        "device": device(),
        "wall_s": round(time.time() - psutil.Process().create_time(), 1),
    }


def combined_hash(files: Iterable[Path], root: Path = ROOT) -> str:
    """SHA-256 over names and contents of the files that exist, whatever their order; names are relative to `root`."""
    whole = hashlib.sha256()
    for name, file in sorted((os.path.relpath(file, root), file) for file in files if file.is_file()):
        whole.update(f"{name}\0{sha256(file)}\n".encode())
    return whole.hexdigest()


def versions(packages: Iterable[str] = PACKAGES) -> dict[str, str]:
    """Versions of Python and of those of the packages that are installed."""
    installed = {"python": platform.python_version()}
    for name in packages:
        try:
            installed[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return installed


def device() -> str:
    """Model of the processor, its usable cores and the threads of a computation; never a host's name."""
    cores = len(psutil.Process().cpu_affinity() or [0])
    threads = os.environ.get("OMP_NUM_THREADS", str(cores))
    return f"{_processor()}, cores: {cores}, threads: {threads}"


def _processor() -> str:
    information = Path("/proc/cpuinfo")
    if information.is_file():
        for line in information.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
