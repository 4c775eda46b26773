#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0: nodes.remove() also deletes the removed node's keyframes from actions that the tree shares with other trees.
# Expected: removing a node of one material leaves another material's animation alone.
# Seen: curves of the node's name go from the action in use, from actions that only NLA strips use, and, where another material animates by the
# same slot of the same action, from under that material too. An action that nothing of the tree uses, and another slot, keep theirs.
# Output of 2026-11-28, both (curves of "Emission" before -> after removing it in material a):
#   in use 1 -> 0     only in an NLA strip 1 -> 0     unassigned 1 -> 1     b by the same slot 1 -> 0     b by another slot 1 -> 1
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

def curves(action, slot=None):
    bags = [bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags]
    return [curve.data_path for bag in bags if slot is None or bag.slot == slot for curve in bag.fcurves]


def animated():
    empty_file()
    owner, node = material("a", "ShaderNodeEmission")
    node.inputs["Strength"].keyframe_insert("default_value", frame=1)
    data = owner.node_tree.animation_data
    data.action.use_fake_user = True
    return owner.node_tree, node, data, data.action


def removed(label, tree, node, action, expected, slot=None):
    before = len(curves(action, slot))
    tree.nodes.remove(node)
    told(f"{label}: {before} ->", len(curves(action, slot)), expected)


tree, node, data, action = animated()
removed("in use", tree, node, action, 0)
tree, node, data, action = animated()
data.nla_tracks.new().strips.new("strip", 1, action)
data.action = None
removed("only in an NLA strip", tree, node, action, 0)
tree, node, data, action = animated()
data.action = None
removed("unassigned", tree, node, action, 1)
for label, same, expected in (("b by the same slot", True, 0), ("b by another slot", False, 1)):
    tree, node, data, action = animated()
    other, other_node = material("b", "ShaderNodeEmission")
    theirs = other.node_tree.animation_data_create()
    theirs.action = action
    theirs.action_slot = data.action_slot if same else action.slots.new("NODETREE", "other")
    if not same:
        other_node.inputs["Strength"].keyframe_insert("default_value", frame=1)
    removed(label, tree, node, action, expected, theirs.action_slot)
done()
PYTHON
blenders 4.5.15 5.3.0
