# The runtime for engines: its arithmetic, its targets, and its answers beside the library's.
add_executable(test_twins runtime/test_twins.c runtime/scalar_twin.c)
set_target_properties(test_twins PROPERTIES C_STANDARD 99)
target_include_directories(test_twins PRIVATE ${PROJECT_SOURCE_DIR}/rt)
target_link_libraries(test_twins PRIVATE resolvent_rt rsv_options)
add_test(NAME runtime_twins COMMAND test_twins)

rsv_add_test(runtime unit/test_runtime.c)
rsv_add_part(runtime slow)
target_link_libraries(test_runtime PRIVATE resolvent_rt_file)
rsv_add_test(turns unit/test_turns.c)
set_tests_properties(turns PROPERTIES LABELS slow)
target_link_libraries(test_turns PRIVATE resolvent_rt_file)

if(NOT RSV_SANITIZE)
    foreach(target freestanding arm windows wasm)
        add_test(NAME runtime_${target} COMMAND bash
            ${CMAKE_CURRENT_SOURCE_DIR}/runtime/test_target.sh ${PROJECT_SOURCE_DIR} ${target})
        set_tests_properties(runtime_${target} PROPERTIES SKIP_RETURN_CODE 77)
    endforeach()
endif()
