# Manual pages, completion, and a package for Debian and Ubuntu: `cpack --config build/release/CPackConfig.cmake`.
if(TARGET resolvent_program AND NOT CMAKE_CROSSCOMPILING)
    set(RSV_MAN_STAMP ${PROJECT_BINARY_DIR}/man/resolvent.1)
    add_custom_command(OUTPUT ${RSV_MAN_STAMP}
        COMMAND bash ${PROJECT_SOURCE_DIR}/cmake/man_pages.sh $<TARGET_FILE:resolvent_program>
            ${PROJECT_BINARY_DIR}/man
        DEPENDS resolvent_program ${PROJECT_SOURCE_DIR}/cmake/man_pages.sh
        COMMENT "Writing manual pages")
    add_custom_target(resolvent_man ALL DEPENDS ${RSV_MAN_STAMP})
    install(DIRECTORY ${PROJECT_BINARY_DIR}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1
        FILES_MATCHING PATTERN "*.1")
    install(FILES ${PROJECT_SOURCE_DIR}/cmake/completion.bash
        DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME resolvent)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "The Resolvent developers <resolvent@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
include(CPack)
