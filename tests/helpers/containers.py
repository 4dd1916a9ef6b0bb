"""Separate PID namespaces, as in containers: the first process of each has the number 1."""

import shutil
import subprocess

UNSHARE = [shutil.which("unshare") or "unshare", "--pid", "--fork", "--mount-proc"]


def unshare_works() -> bool:
    """Return whether this machine allows PID namespaces."""
    try:
        return subprocess.run([*UNSHARE, "true"], capture_output=True, check=False, timeout=20).returncode == 0
    except OSError:
        return False
