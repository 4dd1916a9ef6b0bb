"""Versions of everything that a result depends on: packages, ffmpeg, arithmetic, our code as it was imported."""

import ctypes
import hashlib
import platform
import sys
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Literal

import numpy as np

from emovid.errors import EmovidError
from emovid.video.ffmpeg import version as ffmpeg_version

RecordKind = Literal["video", "trajectory", "measure", "sheet"]
Versions = Mapping[str, str]

_ROOT = Path(__file__).parent.parent
_IMPORTED_AT: int = sys.modules["emovid"].IMPORTED_AT  # [ns]
_MODULES: Mapping[RecordKind, tuple[str, ...]] = {
    "video": ("yaml_models", "scene", "swarm", "video"),
    "trajectory": ("yaml_models", "scene", "swarm"),
    "measure": ("yaml_models", "scene", "swarm", "measure"),
    "sheet": ("video", "figures", "batch"),
}
_PACKAGES: Mapping[RecordKind, tuple[str, ...]] = {
    "video": ("numpy", "scipy", "matplotlib"),
    "trajectory": ("numpy", "scipy"),
    "measure": ("numpy", "scipy"),
    "sheet": ("numpy", "matplotlib"),
}

_Stamp = tuple[int, int, int]


class OtherVersionsError(EmovidError):
    """A worker that would make a result with other versions than its client."""


def versions(only: RecordKind, *, barrier: bool = False) -> dict[str, str]:
    """Return the versions that decide a kind of result, in this process.

    `code` is a digest of our own modules, `arithmetic` one of results that depend on the processor, `projection` one of
    results that depend on the BLAS kernel.

    Args:
        only: kind of the result.
        barrier: whether its scene has a barrier, the only part of a run that uses BLAS.

    Raises:
        EmovidError: if a module was edited near its import, so that the running code is unknown.
    """
    return {
        **{name: _package_version(name) for name in ("emovid", *_PACKAGES[only])},
        **({"ffmpeg": ffmpeg_version()} if only == "video" else {}),
        **({"arithmetic": _arithmetic()} if only != "sheet" else {}),
        **({"projection": _projection()} if barrier else {}),
        "machine": platform.machine(),
        "code": _SOURCES.digest(_MODULES[only]),
    }


def differences(there: Versions, here: Versions) -> str:
    """Return the versions that differ, as in "numpy 2.4.5, here 2.4.6"; "" if none do."""
    return "; ".join(f"{name} {there.get(name)}, here {here[name]}" for name in here if there.get(name) != here[name])


def check_versions(only: RecordKind, expected: Versions) -> None:
    """Raise an `OtherVersionsError` unless this process has the expected versions."""
    if other := differences(versions(only, barrier="projection" in expected), expected):
        raise OtherVersionsError(f"its worker has other versions: {other}")


def _package_version(name: str) -> str:
    """Return the version of a package: that of the imported one, which an upgrade does not change."""
    imported = getattr(sys.modules.get(name), "__version__", None) if name != "emovid" else None
    return str(imported or _installed_version(name))


@cache
def _installed_version(name: str) -> str:
    return version(name)


@cache
def _arithmetic() -> str:
    """Return a digest of the results of functions whose last digit depends on the processor or on numpy's settings.

    Motions depend on these functions and on no others of this kind, except for those of barriers: see `_projection`.
    """
    x = np.linspace(-3.0, 3.0, 4099)
    y = x[::-1] + 0.05
    z = x + 1j * y
    parts = [np.sin(x), np.cos(x), np.exp(x), np.log(np.abs(y)), np.hypot(x, y), np.arctan2(x, y), np.sqrt(x * x)]
    parts += [np.abs(x) ** 1.7, np.abs(z), z * (z[::-1] + x), np.exp(1j * x)]
    return hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest()[:8]


@cache
def _projection() -> str:
    """Return the BLAS kernel of scipy, if known, and a digest of solutions of the quadratic program of barriers.

    A digest of a few solutions alone would miss kernels that differ in rare ones.
    """
    from emovid.swarm.projection import nearest_within  # noqa: PLC0415 - scipy, which other scenes do not need

    rng, sha = np.random.default_rng(0), hashlib.sha256()
    for rows, columns in 8 * ((6, 4), (12, 6), (40, 12)):
        A, b = rng.normal(size=(rows, columns)), rng.uniform(0, 0.3, rows)
        found = nearest_within(0.3 * rng.normal(size=columns), A, b)
        sha.update(b"" if found is None else found.tobytes())
    return f"{_blas_kernel()} {sha.hexdigest()[:8]}".strip()


def _blas_kernel() -> str:
    """Return the name of the kernel that scipy's OpenBLAS has chosen, as in "Haswell"; "" for another library."""
    origin = find_spec("scipy")
    folder = Path(str(origin.origin)).parent if origin else Path()
    for library in (*folder.with_name("scipy.libs").glob("libscipy_openblas*"), *folder.glob(".dylibs/*openblas*")):
        for name in ("scipy_openblas_get_corename", "scipy_openblas_get_corename64_"):
            with suppress(OSError, AttributeError):
                ask = getattr(ctypes.CDLL(str(library)), name)
                ask.restype = ctypes.c_char_p
                return str(ask().decode())
    return ""


class _Sources:
    """The source files of our modules; their digest is of the code in memory, not of later edits."""

    def __init__(self) -> None:
        rooms = sorted({room for rooms in _MODULES.values() for room in rooms})
        self._stamps = {path: _stamp(path) for room in rooms for path in _files(room)}
        self._imported: dict[Path, str] = {}  # digests of imported modules

    def digest(self, rooms: tuple[str, ...]) -> str:
        """Return a digest of all modules of some rooms."""
        sha = hashlib.sha256()
        for path in self._stamps:
            if _dotted(path)[0] in rooms:
                sha.update(self._digest(path).encode())
        return sha.hexdigest()[:16]

    def _digest(self, path: Path) -> str:
        if path in self._imported:
            return self._imported[path]
        try:
            stamp = _stamp(path)
            digest = _content_digest(path, stamp)
        except OSError:
            stamp, digest = (0, 0, 0), "missing"
        if ".".join(("emovid", *_dotted(path))) in sys.modules:
            if stamp != self._stamps[path] or stamp[1] > _IMPORTED_AT:
                raise EmovidError(f"{path}: was edited while emovid was running: start this process again")
            self._imported[path] = digest
        return digest


def _files(room: str) -> list[Path]:
    """Return the files of a package of ours, or the one file of a module."""
    folder = _ROOT / room
    return sorted(folder.glob("*.py")) if folder.is_dir() else [_ROOT / f"{room}.py"]


def _dotted(path: Path) -> tuple[str, ...]:
    """Return the parts of the name of a module inside emovid."""
    return path.relative_to(_ROOT).with_suffix("").parts


def _stamp(path: Path) -> _Stamp:
    """Return the times of the last change of a file's content and status, and its size."""
    stat = path.stat()
    return stat.st_mtime_ns, stat.st_ctime_ns, stat.st_size


@cache
def _content_digest(path: Path, stamp: _Stamp) -> str:  # noqa: ARG001 - the stamp is part of the cache's key
    return hashlib.sha256(path.read_bytes()).hexdigest()


_SOURCES = _Sources()
