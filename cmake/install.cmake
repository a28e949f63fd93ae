# What `cmake --install` leaves. Component `runtime`: program and documentation. Component `development`: headers, libraries,
# and how CMake and pkg-config find them. Components `mpi` and `cuda`: the plug-ins, where they were built. Packages hold one
# of them each (package.cmake).
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/resolvent)

install(TARGETS resolvent EXPORT resolventTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_COMPONENT development)
# by itself, so that engines need none of the library's dependencies: find_package(resolvent COMPONENTS rt)
install(TARGETS resolvent_rt EXPORT resolventRtTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
set(plug_in_of_mpi resolvent_mpi)
set(plug_in_of_cuda resolvent_cuda)
foreach(component IN ITEMS mpi cuda)
    if(TARGET ${plug_in_of_${component}})
        install(TARGETS ${plug_in_of_${component}} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${component})
        install(FILES ${PROJECT_SOURCE_DIR}/cmake/copyright
            DESTINATION ${CMAKE_INSTALL_DOCDIR}-${component} COMPONENT ${component})
    endif()
endforeach()
if(TARGET resolvent_vdb)
    install(TARGETS resolvent_vdb LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime)
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
install(FILES ${PROJECT_SOURCE_DIR}/rt/resolvent_rt.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
# The loader is for engines to take along: it needs cJSON, which the runtime must not.
install(FILES ${PROJECT_SOURCE_DIR}/rt/resolvent_rt_file.h ${PROJECT_SOURCE_DIR}/rt/resolvent_rt_file.c
    DESTINATION ${CMAKE_INSTALL_DATADIR}/resolvent/rt COMPONENT development)
install(EXPORT resolventTargets NAMESPACE resolvent:: DESTINATION ${package_folder} COMPONENT development)
install(EXPORT resolventRtTargets NAMESPACE resolvent:: DESTINATION ${package_folder} COMPONENT development)
if(TARGET resolvent_program)
    set_target_properties(resolvent_program PROPERTIES
        INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR};$ORIGIN/../lib")
    install(TARGETS resolvent_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime)
endif()

# The licence, and the pages that help texts and manual pages name as docs/..., with the pictures and samples they link to
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md
    ${PROJECT_SOURCE_DIR}/cmake/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs COMPONENT runtime
    FILES_MATCHING PATTERN "*.md" PATTERN figures EXCLUDE)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs/figures DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs COMPONENT runtime
    FILES_MATCHING PATTERN "*.png" PATTERN "*.svg" PATTERN "*.jpg")
install(DIRECTORY ${PROJECT_SOURCE_DIR}/samples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT development
    PATTERN CMakeLists.txt EXCLUDE)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/integrations/python/examples
    DESTINATION ${CMAKE_INSTALL_DOCDIR}/integrations/python COMPONENT development)
install(FILES ${PROJECT_SOURCE_DIR}/cmake/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR}-dev COMPONENT development)

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/resolventConfig.cmake.in
    ${PROJECT_BINARY_DIR}/resolventConfig.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/resolventConfigVersion.cmake
    COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/resolventConfig.cmake
    ${PROJECT_BINARY_DIR}/resolventConfigVersion.cmake DESTINATION ${package_folder} COMPONENT development)

# The prefix is found from where the file lies, so that `cmake --install --prefix` may choose it. Embree and meshoptimizer have
# no pkg-config files of their own.
file(RELATIVE_PATH RSV_PC_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
set(RSV_PC_PRIVATE_LIBS "-lmeshoptimizer ${OpenMP_C_FLAGS} -lstdc++ -lm")
if(RSV_EMBREE)
    set(RSV_PC_PRIVATE_LIBS "-lembree${embree_VERSION_MAJOR} ${RSV_PC_PRIVATE_LIBS}")
endif()
configure_file(${PROJECT_SOURCE_DIR}/cmake/resolvent.pc.in ${PROJECT_BINARY_DIR}/resolvent.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/resolvent.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
configure_file(${PROJECT_SOURCE_DIR}/cmake/resolvent_rt.pc.in ${PROJECT_BINARY_DIR}/resolvent_rt.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/resolvent_rt.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
