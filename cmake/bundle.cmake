# What `./dev bundle` installs as the component `bundle`: program, plug-ins, GPU tests and all shared libraries they need,
# but for the C library, so that it runs where only that is installed.
if(NOT TARGET resolvent_program)
    return()
endif()
set(bundled resolvent_program)
get_property(gpu_tests GLOBAL PROPERTY RSV_GPU_TESTS)
foreach(target IN ITEMS resolvent_cuda resolvent_emulated ${gpu_tests})
    if(TARGET ${target})
        list(APPEND bundled ${target})
    endif()
endforeach()
install(TARGETS ${bundled} RUNTIME_DEPENDENCY_SET bundle_libraries
    RUNTIME DESTINATION bin COMPONENT bundle EXCLUDE_FROM_ALL
    LIBRARY DESTINATION lib COMPONENT bundle EXCLUDE_FROM_ALL)
install(RUNTIME_DEPENDENCY_SET bundle_libraries
    PRE_EXCLUDE_REGEXES "^ld-linux" "^lib(c|m|dl|rt|pthread|resolv)\\.so" "^libresolvent_"
    LIBRARY DESTINATION lib COMPONENT bundle EXCLUDE_FROM_ALL)
install(PROGRAMS ${PROJECT_SOURCE_DIR}/cmake/run-gpu DESTINATION . COMPONENT bundle EXCLUDE_FROM_ALL)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md DESTINATION . COMPONENT bundle EXCLUDE_FROM_ALL)
# Libraries that look for theirs where they lay would not look here.
install(CODE [[
    file(GLOB libraries ${CMAKE_INSTALL_PREFIX}/lib/*.so*)
    foreach(library IN LISTS libraries)
        if(NOT IS_SYMLINK ${library})
            file(RPATH_REMOVE FILE ${library})
        endif()
    endforeach()
]] COMPONENT bundle EXCLUDE_FROM_ALL)
