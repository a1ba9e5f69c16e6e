"""A live view of a played character in a notebook: a widget with a plain canvas, no build step and no network."""

from stylephase.runtime.viewer.widget import Viewer

__all__ = ["Viewer"]
