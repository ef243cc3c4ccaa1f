"""Results on disk, whole or not at all: written beside their place and moved there once complete."""

from __future__ import annotations

import errno
import glob
import json
import os
import platform
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

from zoo.errors import InputError, WorkError


def writable_folder(path: str | Path) -> Path:
    """A folder that exists and takes files; created where it is missing.

    Raises:
        InputError: it cannot be created, or nothing can be written into it.
    """
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder):  # without a name, where there is such a thing: a process that is killed here leaves nothing
            pass
    except OSError as error:
        raise InputError(f"{folder}: cannot be written to ({error.strerror}); choose another folder") from error
    return folder


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """A temporary sibling to write to; takes the place of `path` when the block ends well and is removed when it does not.

    The sibling lies in the same folder, since a rename is only atomic within one file system. One that a killed process has left goes with the
    next that is written.

    Raises:
        InputError: the folder cannot be written to, or `path` is a folder.
        WorkError: writing failed half-way, as on a full disk.
    """
    target = Path(path)
    writable_folder(target.parent)
    if target.is_dir():
        raise InputError(f"{target}: is a folder; name a file")
    _clear_left(target)
    temporary = _sibling(target)
    try:
        yield temporary
        temporary.replace(target)
    except OSError as error:
        raise WorkError(f"{target}: could not be written ({error.strerror or error})") from error
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def folder_replacing(path: str | Path) -> Iterator[Path]:
    """A temporary folder to write to; becomes `path` when the block ends well and is removed when it does not.

    Where somebody else's has taken that place in the meantime, theirs stays. One that a killed process has left goes with the next.

    Raises:
        InputError: the folder above it cannot be written to.
        WorkError: writing failed half-way, as on a full disk.
    """
    target = Path(path)
    writable_folder(target.parent)
    _clear_left(target)
    temporary = _sibling(target)
    try:
        temporary.mkdir()
        yield temporary
        if not target.is_dir():
            _moved(temporary, target)
    except OSError as error:
        raise WorkError(f"{target}: could not be written ({error.strerror or error})") from error
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def _moved(folder: Path, target: Path) -> None:
    """Put a folder where there was none, unless somebody else's is there by now."""
    try:
        folder.replace(target)
    except OSError:
        if not target.is_dir():
            raise


def _sibling(path: Path) -> Path:
    # Ends in .part, so that no glob for measurements or results takes it for one; says who writes it, so that what nobody writes any more can go.
    return path.with_name(f".{path.name}.{platform.node()}.{os.getpid()}.{secrets.token_hex(4)}.part")


def _clear_left(path: Path) -> None:
    """Remove what was to become `path` and was left by processes of this machine that were killed."""
    if os.name != "posix":  # elsewhere a process cannot be asked for without harm
        return
    for left in path.parent.glob(glob.escape(f".{path.name}.{platform.node()}.") + "*.part"):
        process = left.name.split(".")[-3]
        if process.isdecimal() and not _lives(int(process)):
            shutil.rmtree(left, ignore_errors=True) if left.is_dir() else left.unlink(missing_ok=True)


def _lives(process: int) -> bool:
    try:
        os.kill(process, 0)
    except OSError as error:  # of somebody else's process it is refused
        return error.errno != errno.ESRCH
    return True


def write_text(path: str | Path, text: str) -> Path:
    """Writes a text file in UTF-8 and returns its path.

    Raises:
        InputError: the folder cannot be written to.
        WorkError: writing failed half-way.
    """
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")
    return Path(path)


def write_json(path: str | Path, data: Any) -> Path:
    """Writes JSON in UTF-8, indented, and returns its path.

    Raises:
        ValueError: there is a NaN or an infinity in it; they are no JSON, and a reader in another language stops at them.
        InputError: the folder cannot be written to.
        WorkError: writing failed half-way.
    """
    return write_text(path, json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n")
