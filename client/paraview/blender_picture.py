"""Draws head.ply, as multitetra-client fetch writes it, into head.png: blender -b -P blender_picture.py"""
import bpy
from mathutils import Vector

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_mesh.ply(filepath="head.ply")      # Vertex colors are its color attribute "Col".
surface, scene = bpy.context.object, bpy.context.scene
material = bpy.data.materials.new("surface")
material.use_nodes = True
colors = material.node_tree.nodes.new("ShaderNodeVertexColor")
colors.layer_name = "Col"
material.node_tree.links.new(colors.outputs["Color"], material.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
surface.data.materials.append(material)
middle = sum((surface.matrix_world @ Vector(corner) for corner in surface.bound_box), Vector()) / 8
camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
camera.location = middle + 3 * max(surface.dimensions) * Vector((0.3, -1, 0.25))
camera.rotation_euler = (middle - camera.location).to_track_quat("-Z", "Y").to_euler()
camera.data.clip_end = 10 * max(surface.dimensions)
sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
sun.data.energy, sun.rotation_euler = 3, camera.rotation_euler
for thing in (camera, sun):
    scene.collection.objects.link(thing)
scene.camera, scene.render.engine, scene.render.filepath = camera, "CYCLES", "head.png"
scene.cycles.samples, scene.cycles.use_denoising = 16, False
bpy.ops.render.render(write_still=True)
