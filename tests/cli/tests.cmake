# The program as its users meet it: one shell script per subject.
if(TARGET resolvent_program)
    foreach(subject usage animation files surroundings budget bad_input bake document gltf probe daylight photometry luminaire certify render solve update relight gpu view edit python scene cancel bench)
        add_test(NAME cli_${subject} COMMAND bash
            ${CMAKE_CURRENT_SOURCE_DIR}/cli/test_${subject}.sh $<TARGET_FILE:resolvent_program>)
        set_tests_properties(cli_${subject} PROPERTIES ENVIRONMENT "${RSV_LEAKS}")
    endforeach()
    set(volume_maker "")
    if(RSV_OPENVDB)
        add_executable(make_volumes cli/make_volumes.cpp)
        target_include_directories(make_volumes SYSTEM PRIVATE ${OPENVDB_INCLUDE_DIR})
        # templates of OpenVDB, for a few small files: optimised they take twice the time to compile
        target_compile_options(make_volumes PRIVATE -fvisibility=default -O0)
        target_link_libraries(make_volumes PRIVATE ${OPENVDB_LIBRARY} ${OPENVDB_TBB_LIBRARY} PkgConfig::OPENEXR)
        set(volume_maker $<TARGET_FILE:make_volumes>)
    endif()
    add_test(NAME cli_volume COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/cli/test_volume.sh
        $<TARGET_FILE:resolvent_program> ${volume_maker})
    set_tests_properties(cli_volume PROPERTIES LABELS slow ENVIRONMENT "${RSV_LEAKS}")
    set_tests_properties(cli_python cli_gltf PROPERTIES SKIP_RETURN_CODE 77)
    # what they run, the sanitizers see in the unit tests
    set_tests_properties(cli_animation cli_bake cli_bench cli_budget cli_certify cli_daylight cli_document cli_edit cli_files cli_gltf cli_gpu cli_luminaire cli_photometry cli_relight cli_render cli_scene cli_solve cli_surroundings cli_update
        cli_view PROPERTIES LABELS slow)
    add_test(NAME cli_cluster COMMAND bash
        ${CMAKE_CURRENT_SOURCE_DIR}/cli/test_cluster.sh $<TARGET_FILE:resolvent_program>)
    # `./dev cluster` installs what they need, and runs them. MPI and PETSc keep what they allocate to the end
    set_tests_properties(cli_cluster PROPERTIES SKIP_RETURN_CODE 77 LABELS "cluster;long"
        ENVIRONMENT "OMP_WAIT_POLICY=passive")
    add_test(NAME cli_scaling COMMAND bash
        ${CMAKE_CURRENT_SOURCE_DIR}/cli/test_scaling.sh $<TARGET_FILE:resolvent_program>)
    set_tests_properties(cli_scaling PROPERTIES SKIP_RETURN_CODE 77 LABELS "cluster;long"
        ENVIRONMENT "OMP_WAIT_POLICY=passive")
    add_test(NAME cli_kill COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/cli/test_kill.sh $<TARGET_FILE:resolvent_program>)
    add_test(NAME cli_kill_200 COMMAND bash
        ${CMAKE_CURRENT_SOURCE_DIR}/cli/test_kill.sh $<TARGET_FILE:resolvent_program> 200)
    set_tests_properties(cli_kill PROPERTIES LABELS slow)
    set_tests_properties(cli_kill_200 PROPERTIES LABELS long)
    # other tests would be slowed down, and the time it takes to stop with them
    set_tests_properties(cli_cancel PROPERTIES RUN_SERIAL TRUE)
endif()
if(TARGET resolvent_program AND TARGET sample_engine_loop)
    add_test(NAME cli_runtime COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/cli/test_runtime.sh
        $<TARGET_FILE:resolvent_program> $<TARGET_FILE:sample_engine_loop>)
    set_tests_properties(cli_runtime PROPERTIES LABELS slow ENVIRONMENT "${RSV_LEAKS}")
endif()
if(TARGET resolvent_program AND TARGET sample_window)
    add_test(NAME cli_window COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/cli/test_window.sh
        $<TARGET_FILE:resolvent_program> $<TARGET_FILE:sample_window>)
    set_tests_properties(cli_window PROPERTIES LABELS slow SKIP_RETURN_CODE 77)
endif()
if(TARGET resolvent_program)
    add_test(NAME cli_docs COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/cli/test_docs.sh
        $<TARGET_FILE:resolvent_program> ${PROJECT_SOURCE_DIR}/docs/start-here.md)
    add_test(NAME cli_docs_whole COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/cli/test_docs.sh
        $<TARGET_FILE:resolvent_program> ${PROJECT_SOURCE_DIR}/docs/start-here.md whole)
    set_tests_properties(cli_docs PROPERTIES LABELS slow ENVIRONMENT "${RSV_LEAKS}")
    set_tests_properties(cli_docs_whole PROPERTIES LABELS long)
endif()
# the test of the package runs it twice
foreach(name IN ITEMS own_memory own_files own_threads cancel two_lights door)
    if(TARGET sample_${name})
        add_test(NAME sample_${name} COMMAND sample_${name})
        set_tests_properties(sample_${name} PROPERTIES ENVIRONMENT "${RSV_LEAKS}")
    endif()
endforeach()
if(TARGET sample_minimal AND (RSV_SANITIZE OR NOT TARGET resolvent_program))
    add_test(NAME sample_minimal COMMAND sample_minimal)
    set_tests_properties(sample_minimal PROPERTIES LABELS slow)
endif()
if(TARGET resolvent_program AND NOT RSV_SANITIZE)
    add_test(NAME package COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/cli/test_package.sh
        ${CMAKE_BINARY_DIR} ${PROJECT_SOURCE_DIR})
    add_library(failing_malloc MODULE cli/failing_malloc.c)
    set_target_properties(failing_malloc PROPERTIES C_VISIBILITY_PRESET default)
    add_test(NAME cli_memory COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/cli/test_memory.sh $<TARGET_FILE:resolvent_program>
        $<TARGET_FILE:failing_malloc>)
    add_test(NAME bundle COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/cli/test_bundle.sh ${CMAKE_BINARY_DIR})
endif()
# the Python package, whose tests lie with it
if(NOT RSV_SANITIZE)
    add_test(NAME python_package COMMAND bash ${PROJECT_SOURCE_DIR}/integrations/python/tests/test_package.sh
        ${CMAKE_BINARY_DIR})
    set_tests_properties(python_package PROPERTIES LABELS slow SKIP_RETURN_CODE 77)
endif()

# the add-on for Godot 4: what Godot 3 can run of it, and all of it in Godot 4 for the web, which `./dev assets` fetches
if(TARGET resolvent_program AND NOT RSV_SANITIZE)
    add_test(NAME godot_scripts COMMAND bash ${PROJECT_SOURCE_DIR}/integrations/godot/tests/test_godot3.sh
        $<TARGET_FILE:resolvent_program>)
    add_test(NAME godot_addon COMMAND bash ${PROJECT_SOURCE_DIR}/integrations/godot/tests/test_godot4.sh
        $<TARGET_FILE:resolvent_program>)
    set_tests_properties(godot_scripts godot_addon PROPERTIES LABELS long SKIP_RETURN_CODE 77)
endif()

# the Blender add-on, in the real Blender; its tests lie with it, too
if(TARGET resolvent_program AND NOT RSV_SANITIZE)
    foreach(kind quick all window cycles)
        add_test(NAME blender_${kind} COMMAND bash
            ${PROJECT_SOURCE_DIR}/integrations/blender/tests/test_blender.sh ${CMAKE_BINARY_DIR} ${kind})
        set_tests_properties(blender_${kind} PROPERTIES LABELS long SKIP_RETURN_CODE 77)
    endforeach()
endif()
