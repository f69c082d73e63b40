"""Stand-ins for those libraries of LeRobot's that are too large for a test: PyTorch, torchvision and OpenCV, gigabytes as PyPI has them.

LeRobot's loops need them for images and networks alone, but import them at the top. A stand-in gives a class of its own for each name that is
asked of it, which can be inherited from, named in annotations, and used as a decorator; nothing can be computed with it. Numbers read from a
data set would be tensors: here `torch.tensor` gives NumPy's arrays, which convert to float as tensors do. All else is the real thing, from PyPI:
the loops, processors, configurations, the discovery of plugins, and the data set's writer and reader with pandas, PyArrow, datasets and PyAV.
"""

import abc
import importlib.abc
import importlib.machinery
import sys
import types

import numpy as np

NAMES = ("torch", "torchvision", "cv2")


class _Name(abc.ABCMeta):
    """What an attribute of a stand-in is: a class, whose own attributes are such classes, too."""

    def __getattr__(cls, name):
        return _named(cls, name)

    def __call__(cls, *given, **named):
        if "_stands_in" not in cls.__dict__:
            return super().__call__(*given, **named)
        # As a decorator it changes nothing.
        return given[0] if len(given) == 1 and callable(given[0]) else super().__call__()

    def __or__(cls, other):
        return object

    __ror__ = __or__


class _Nothing:
    """A decorator that changes nothing and a context that does nothing, as of torch.no_grad()."""

    def __call__(self, function):
        return function

    def __enter__(self):
        return self

    def __exit__(self, *_error):
        return False


def _named(of, name):
    if name.startswith("__"):
        raise AttributeError(name)
    bases = () if name[0].isupper() else (_Nothing,)
    made = _Name(name, bases, {"__module__": of.__name__, "_stands_in": True})
    setattr(of, name, made)
    return made


class _Module(types.ModuleType):
    def __getattr__(self, name):
        return _named(self, name)


class _Finder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in NAMES:
            return importlib.machinery.ModuleSpec(name, self, is_package=True)
        return None

    def create_module(self, spec):
        module = _Module(spec.name)
        module.__path__ = []
        if spec.name == "torch":
            module.tensor = np.asarray
        return module

    def exec_module(self, module):
        pass


def install():
    """From now on they are found before anything that is installed."""
    sys.meta_path.insert(0, _Finder())
