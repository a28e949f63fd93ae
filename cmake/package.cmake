# Manual pages, completion, and packages for Debian and Ubuntu: `cpack --config build/release/CPackConfig.cmake`.
if(TARGET resolvent_program AND NOT CMAKE_CROSSCOMPILING)
    set(RSV_MAN_STAMP ${PROJECT_BINARY_DIR}/man/resolvent.1)
    add_custom_command(OUTPUT ${RSV_MAN_STAMP}
        COMMAND bash ${PROJECT_SOURCE_DIR}/cmake/man_pages.sh $<TARGET_FILE:resolvent_program>
            ${PROJECT_BINARY_DIR}/man
        DEPENDS resolvent_program ${PROJECT_SOURCE_DIR}/cmake/man_pages.sh
        COMMENT "Writing manual pages")
    add_custom_target(resolvent_man ALL DEPENDS ${RSV_MAN_STAMP})
    install(DIRECTORY ${PROJECT_BINARY_DIR}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT runtime
        FILES_MATCHING PATTERN "*.1")
    install(FILES ${PROJECT_SOURCE_DIR}/cmake/completion.bash
        DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME resolvent
        COMPONENT runtime)
    install(FILES ${PROJECT_SOURCE_DIR}/cmake/completion.zsh
        DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions RENAME _resolvent
        COMPONENT runtime)
    install(FILES ${PROJECT_SOURCE_DIR}/cmake/completion.fish
        DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d RENAME resolvent.fish
        COMPONENT runtime)
endif()

set(RSV_PACKAGE_CONTACT "Resolvent developers <noreply@resolvent.example>" CACHE STRING "Maintainer of the packages")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT ${RSV_PACKAGE_CONTACT})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL runtime development)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)

set(CPACK_COMPONENT_RUNTIME_DESCRIPTION
    "Solves the global illumination of a scene once, for pictures, measured\nirradiance, baked light and other lights at run time: the program.")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME resolvent)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)

# A static library brings no dependencies of its own: these are what resolventConfig.cmake and resolvent.pc look for.
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
    "Headers and static libraries of Resolvent and of its runtime for engines,\nand how CMake and pkg-config find them.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME resolvent-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    "libembree-dev, libtbb-dev, libdraco-dev, libmeshoptimizer-dev, libassimp-dev, libopenexr-dev, libwebp-dev, libcjson-dev, zlib1g-dev, libzstd-dev, pkg-config")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS resolvent)

# Plug-ins have packages of their own: the program does without MPI and without a GPU.
set(description_of_mpi "Several processes at one scene, by MPI, and PETSc's solvers: a plug-in of Resolvent.")
set(description_of_cuda "Work on NVIDIA's GPUs: a plug-in of Resolvent. It needs their driver.")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS "resolvent-mpi, resolvent-cuda")
foreach(component IN ITEMS mpi cuda)
    if(TARGET ${plug_in_of_${component}})
        string(TOUPPER ${component} upper)
        list(APPEND CPACK_COMPONENTS_ALL ${component})
        set(CPACK_COMPONENT_${upper}_DESCRIPTION ${description_of_${component}})
        set(CPACK_DEBIAN_${upper}_PACKAGE_NAME resolvent-${component})
        set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION graphics)
        set(CPACK_DEBIAN_${upper}_PACKAGE_SHLIBDEPS ON)
        set(CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS "resolvent (= ${PROJECT_VERSION})")
    endif()
endforeach()
include(CPack)
