"""The loggers of mlagents_envs.logging_util, with its names: each writes to standard output, with one level for all.

    log = get_logger(__name__)
    set_log_level(DEBUG)

ML-Agents' trainers log by it. The kit's own loggers are those of Python, below netmq_example.
"""

import logging
import sys
from logging import CRITICAL, DEBUG, ERROR, FATAL, INFO, NOTSET, WARNING

__all__ = ["CRITICAL", "DEBUG", "ERROR", "FATAL", "INFO", "NOTSET", "WARNING", "get_logger", "set_log_level"]

SHORT = logging.Formatter("[%(levelname)s] %(message)s")
LONG = logging.Formatter("%(asctime)s %(levelname)s [%(filename)s:%(lineno)d] %(message)s", "%Y-%m-%d %H:%M:%S")

HANDLER = logging.StreamHandler(sys.stdout)
HANDLER.setFormatter(SHORT)
# Those that were asked for.
LOGGERS: set[logging.Logger] = set()
level_of_all = NOTSET


def get_logger(name: str) -> logging.Logger:
    logger = logging.getLogger(name)
    LOGGERS.add(logger)
    logger.addHandler(HANDLER)
    if level_of_all != NOTSET:
        logger.setLevel(level_of_all)
    return logger


def set_log_level(log_level: int) -> None:
    """Also for the loggers that are asked for later. DEBUG has the time and the place of each line."""
    global level_of_all
    level_of_all = log_level
    HANDLER.setFormatter(LONG if log_level == DEBUG else SHORT)
    for logger in LOGGERS:
        logger.setLevel(log_level)
