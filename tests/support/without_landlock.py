"""Runs a program as on a kernel without Landlock.

    without_landlock.py PROGRAM [ARGUMENT...]
"""
import ctypes
import errno
import os
import sys

ALLOW, FAIL, CREATE_RULESET = 0x7FFF0000, 0x00050000, 444

seccomp = ctypes.CDLL("libseccomp.so.2")
seccomp.seccomp_init.restype = ctypes.c_void_p
rules = ctypes.c_void_p(seccomp.seccomp_init(ALLOW))
if seccomp.seccomp_rule_add(rules, FAIL | errno.ENOSYS, CREATE_RULESET, 0) != 0 or seccomp.seccomp_load(rules) != 0:
    sys.exit("Landlock cannot be hidden.")
os.execv(sys.argv[1], sys.argv[1:])
