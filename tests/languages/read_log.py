"""A log by the generated Python types, against the same log as a table, read by numpy.

  read_log.py LOG CSV
"""

import struct
import sys

import numpy
import torqued

commands = []
with open(sys.argv[1], "rb") as log:
    while header := log.read(28):
        sync, number, timestamp, channel_size, data_size = struct.unpack(">IqqII", header)
        assert sync == 0xEDA1DA01
        channel = log.read(channel_size).decode()
        data = log.read(data_size)
        if channel == "TORQUED_COMMAND":
            commands.append(torqued.torque_command_t.decode(data))
        if channel == "TORQUED_MODEL":
            model = torqued.model_info_t.decode(data)
            assert model.name == "human-subject01"

walk = numpy.genfromtxt(sys.argv[2], delimiter=",", names=True, dtype=None, encoding="utf-8")
assert len(walk) == len(commands) == 447
for k, joint in enumerate(model.joint_names):
    assert numpy.array_equal(walk["tau_" + joint], [command.torque[k] for command in commands]), joint
assert numpy.array_equal(walk["fzR"], [command.right.fz for command in commands])
assert numpy.array_equal(walk["zmp"], [command.zmp for command in commands])
for k, coordinate in enumerate(model.absolute_names):
    assert numpy.array_equal(walk["a_" + coordinate], [command.a[k] for command in commands]), coordinate
    assert numpy.array_equal(walk["a_" + coordinate], walk["dd" + coordinate]), coordinate
for k, coordinate in enumerate(model.base_names):
    assert numpy.array_equal(walk["a_" + coordinate], [command.base_a[k] for command in commands]), coordinate
assert numpy.array_equal(walk["adjustment"], [command.adjustment for command in commands])
assert numpy.array_equal(walk["time"], walk["utime"] / 1e6)
names = {"TIPS": 4, "RELAXED": 32, "INCONSISTENT": 64, "CONTACT_ACCELERATION": 2048}
assert numpy.array_equal(walk["flags"], [sum(names[name] for name in text.split("|") if name) for text in walk["flag_names"]])
assert set(walk["method"]) == {"none", "constrained"}
print(len(commands), "commands,", walk["tau_left_ankle"].max(), "N m at most at the left ankle")
total = 0.0  # one after another: newer sum() rounds less
for command in commands:
    total += command.torque[0]
print(total)
