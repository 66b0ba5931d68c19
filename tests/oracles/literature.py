"""Mechanisms of the literature as a reader of the documentation types them."""

from __future__ import annotations

GOLDBERG = """
name = "goldberg"
title = "Goldberg's 5R linkage: two Bennett linkages with a link in common"
driven = ["A"]
[parameters]
alpha = "40 deg"
beta = "75 deg"
gamma = "55 deg"
a = "100 mm"
b = "a*sin(beta)/sin(alpha)"
c = "a*sin(gamma)/sin(alpha)"
[home]
A = "90 deg"
[guess]
B = "140 deg"
C = "-90 deg"
D = "-60 deg"
E = "-140 deg"
[bodies]
l1 = {}
l2 = {}
l3 = {}
l4 = {}
[joints]
A = { kind = "revolute", parent = "base", child = "l1", actuated = true }
B = { kind = "revolute", parent = "l1", child = "l2", on_parent = { at = ["a", 0, 0], turns = [["x", "alpha"]] } }
C = { kind = "revolute", parent = "l2", child = "l3", on_parent = { at = ["b + c", 0, 0], turns = [["x", "beta + gamma"]] } }
D = { kind = "revolute", parent = "l3", child = "l4", on_parent = { at = ["a", 0, 0], turns = [["x", "alpha"]] } }
E = { kind = "revolute", parent = "l4", child = "base", on_parent = { at = ["c", 0, 0], turns = [["x", "gamma"]] }, on_child = { at = ["-b", 0, 0], turns = [["x", "-beta"]] } }
"""

JACK = """
name = "jack"
title = "Car jack: a screw across a rhombus"
driven = ["H"]
[parameters]
l = "150 mm"
pitch = "4 mm"
[guess]
A = "40 deg"
B = "140 deg"
H = "361 rad"
S = "-361 rad"
N = "-40 deg"
M = "-140 deg"
C = "140 deg"
D = "40 deg"
G = "193 mm"
[bodies]
ll = {}
rl = {}
lu = {}
ru = {}
head = {}
nut = {}
bush = {}
screw = {}
[joints]
A = { kind = "revolute", parent = "base", child = "rl" }
B = { kind = "revolute", parent = "base", child = "ll" }
N = { kind = "revolute", parent = "rl", child = "nut", on_parent = { at = ["l", 0, 0] } }
M = { kind = "revolute", parent = "ll", child = "bush", on_parent = { at = ["l", 0, 0] } }
S = { kind = "revolute", parent = "bush", child = "screw", actuated = true, on_parent = { axis = [1, 0, 0] }, on_child = { axis = [1, 0, 0] } }
H = { kind = "helical", parent = "screw", child = "nut", pitch = "pitch", on_parent = { axis = [1, 0, 0] }, on_child = { axis = [1, 0, 0] } }
C = { kind = "revolute", parent = "nut", child = "ru" }
D = { kind = "revolute", parent = "bush", child = "lu" }
E = { kind = "revolute", parent = "ru", child = "lu", on_parent = { at = ["l", 0, 0] }, on_child = { at = ["l", 0, 0] } }
F = { kind = "revolute", parent = "ru", child = "head", on_parent = { at = ["l", 0, 0] } }
G = { kind = "prismatic", parent = "base", child = "head", on_parent = { axis = [0, 1, 0] }, on_child = { axis = [0, 1, 0] } }
"""
