"""Files of surfaces, read and written. The format modules are imported when they are needed."""

from henkei.io.files import read, write

__all__ = ["read", "write"]
