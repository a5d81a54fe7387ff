"""The loggers of mlagents_envs.logging_util, with its names: each writes to standard output, with one level for all.

    log = get_logger(__name__)
    set_log_level(DEBUG)

ML-Agents' trainers log by it. The kit's own loggers are those of Python, below netmq_example.
"""

import logging
import sys

__all__ = ["CRITICAL", "DEBUG", "ERROR", "FATAL", "INFO", "NOTSET", "WARNING", "get_logger", "set_log_level"]

CRITICAL = logging.CRITICAL
FATAL = logging.FATAL
ERROR = logging.ERROR
WARNING = logging.WARNING
INFO = logging.INFO
DEBUG = logging.DEBUG
NOTSET = logging.NOTSET

SHORT = logging.Formatter("[%(levelname)s] %(message)s")
LONG = logging.Formatter("%(asctime)s %(levelname)s [%(filename)s:%(lineno)d] %(message)s", "%Y-%m-%d %H:%M:%S")

# Each logger that was asked for, with its handler.
HANDLERS: dict[logging.Logger, logging.Handler] = {}
level_of_all = NOTSET


def get_logger(name: str) -> logging.Logger:
    logger = logging.getLogger(name)
    if logger not in HANDLERS:
        HANDLERS[logger] = logging.StreamHandler(sys.stdout)
        logger.addHandler(HANDLERS[logger])
    adjust(logger)
    return logger


def set_log_level(log_level: int) -> None:
    """Also for the loggers that are asked for later. DEBUG has the time and the place of each line."""
    global level_of_all
    level_of_all = log_level
    for logger in HANDLERS:
        adjust(logger)


def adjust(logger: logging.Logger) -> None:
    HANDLERS[logger].setFormatter(LONG if level_of_all == DEBUG else SHORT)
    if level_of_all != NOTSET:
        logger.setLevel(level_of_all)
