"""Does drawing without a display work here? `python -m stylephase.report.probe` says so, or what to install.

Where the graphics libraries are missing, the first picture ends the process by a segmentation fault, which no
exception handler sees. So the probe draws in a process of its own.
"""

import subprocess
import sys

from stylephase.errors import InputError

_DEBIAN_PACKAGES = "libegl1 libgl1 libgl1-mesa-dri libxcursor1 libxrender1"
_DRAW = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(64, 64))
plotter.set_background("white")
plotter.add_mesh(pyvista.Sphere(), color="black")
picture = plotter.screenshot(return_img=True)
print(type(plotter.render_window).__name__ if picture.min() < picture.max() else "")
"""


def probe_rendering() -> str:
    """Draw a sphere off screen and return the name of the window class that drew it.

    Raises InputError that names the Debian packages to install where it fails or the picture is blank.
    """
    done = subprocess.run([sys.executable, "-c", _DRAW], capture_output=True, text=True, check=False)
    window = done.stdout.strip()
    if done.returncode or not window:
        reason = f"off-screen rendering does not work (status {done.returncode})"
        raise InputError(f"{reason}; on Debian: apt-get install {_DEBIAN_PACKAGES}")
    return window


if __name__ == "__main__":
    try:
        print(f"off-screen rendering works: {probe_rendering()}")
    except InputError as error:
        print(f"stylephase: {error}", file=sys.stderr)
        sys.exit(2)
