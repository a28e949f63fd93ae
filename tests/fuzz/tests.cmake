# What fuzzing tries: each reader of files. The preset `fuzz` makes a libFuzzer program of every one; the others
# replay seeds and what was found once.
add_library(rsv_fuzz_readers STATIC fuzz/readers.c fuzz/kept_files.c)
target_link_libraries(rsv_fuzz_readers PUBLIC rsv_test_support rsv_program_parts)

if(RSV_FUZZ)
    foreach(extension IN ITEMS glb gltf obj ply stl dae fbx exr hdr png jpg webp tga bmp gif ktx2 safetensors csv txt epw wea ies ldt
            history scene rows)
        add_executable(fuzz_${extension} fuzz/fuzz.c)
        target_compile_definitions(fuzz_${extension} PRIVATE FUZZ_EXTENSION=".${extension}")
        target_link_libraries(fuzz_${extension} PRIVATE rsv_fuzz_readers -fsanitize=fuzzer)
    endforeach()
endif()

add_executable(fuzz_replay fuzz/replay.c)
target_link_libraries(fuzz_replay PRIVATE rsv_fuzz_readers)
file(GLOB RSV_FUZZ_FILES CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/fuzz/seeds/*
    ${CMAKE_CURRENT_SOURCE_DIR}/fuzz/found/*)
add_test(NAME fuzz_replay COMMAND fuzz_replay ${RSV_FUZZ_FILES})
set_tests_properties(fuzz_replay PROPERTIES ENVIRONMENT "${RSV_LEAKS}")
file(MAKE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/kept/history ${CMAKE_CURRENT_BINARY_DIR}/kept/scene
    ${CMAKE_CURRENT_BINARY_DIR}/kept/rows)
add_test(NAME fuzz_kept COMMAND fuzz_replay --kept ${CMAKE_CURRENT_BINARY_DIR}/kept)
set_tests_properties(fuzz_kept PROPERTIES ENVIRONMENT "${RSV_LEAKS}")
