#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0: keyframes of a group node's socket when the group's sockets change places, or another group is put in.
# Expected: a keyframe follows its socket, or (as long known) its path inputs[i] stays as it is; and the name of a socket counts.
# Seen: 4.5.15 never touches the path, so moving a socket makes the keyframes drive its neighbor. 5.3.0 rewrites the path by the socket's
# identifier. With another group in `node_tree` that means: keyframes and values go to the socket that was CREATED at the same turn
# there, whatever its name or place, so code for both versions must set the paths itself.
# Output of 2026-11-28 (A B C, keyed is B; the other group was made as B C A D and arranged as A D C B):
#   Blender 4.5.15  C moved to the front: inputs[1] = A     other group: inputs[1] = D
#   Blender 5.3.0   C moved to the front: inputs[2] = B     other group: inputs[2] = C
#   both: values A 1, B 2, C 3 are A 3, D 0, C 2, B 1 in the other group
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

OLD = VERSION < (5, 0)


def group(created, order):
    tree = bpy.data.node_groups.new("group", "ShaderNodeTree")
    made = {name: tree.interface.new_socket(name, in_out="INPUT", socket_type="NodeSocketFloat") for name in created}
    for place, name in enumerate(order):
        tree.interface.move(made[name], place)
    tree.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketFloat")
    return tree


def keyed():
    empty_file()
    tree = material("m", "ShaderNodeEmission")[0].node_tree
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group("ABC", "ABC")
    for value, socket in enumerate(node.inputs, 1):
        socket.default_value = value
    node.inputs["B"].keyframe_insert("default_value", frame=1)
    return tree, node


def driven(tree):
    (path,) = [curve.data_path for layer in tree.animation_data.action.layers for strip in layer.strips for bag in strip.channelbags for curve in bag.fcurves]
    path = path.rsplit(".", 1)[0]
    return f"{path[-9:]} = {tree.path_resolve(path).name}"


tree, node = keyed()
told("keyed", driven(tree), "inputs[1] = B")
node.node_tree.interface.move(node.node_tree.interface.items_tree["C"], 0)
told("C moved to the front", driven(tree), "inputs[1] = A" if OLD else "inputs[2] = B")
tree, node = keyed()
node.node_tree = group("BCAD", "ADCB")
told("other group", driven(tree), "inputs[1] = D" if OLD else "inputs[2] = C")
told("its values", " ".join(f"{socket.name} {socket.default_value:g}" for socket in node.inputs), "A 3 D 0 C 2 B 1")
done()
PYTHON
blenders 4.5.15 5.3.0
