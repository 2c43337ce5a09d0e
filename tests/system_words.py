"""What this operating system calls the errors that our messages end in."""

import errno
import os

NO_FILE = os.strerror(errno.ENOENT)
NO_FOLDER = os.strerror(errno.ENOTDIR)
IS_FOLDER = os.strerror(errno.EISDIR)
NOT_PERMITTED = os.strerror(errno.EACCES)
NO_SPACE = os.strerror(errno.ENOSPC)
FILE_TOO_LARGE = os.strerror(errno.EFBIG)
CANNOT_READ = os.strerror(errno.EIO)
