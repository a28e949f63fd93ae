## Imports glTF files baked by `resolvent bake` with their light.
@tool
extends EditorPlugin

const BakedGltf = preload("baked_gltf.gd")

var _importer := BakedGltf.new()


func _enter_tree() -> void:
	GLTFDocument.register_gltf_document_extension(_importer, true)


func _exit_tree() -> void:
	GLTFDocument.unregister_gltf_document_extension(_importer)
