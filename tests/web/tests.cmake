if(TARGET resolvent_program AND NOT RSV_SANITIZE)
    add_test(NAME web COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/web/test_web.sh
        $<TARGET_FILE:resolvent_program> ${PROJECT_SOURCE_DIR})
    set_tests_properties(web PROPERTIES LABELS slow SKIP_RETURN_CODE 77)
    add_test(NAME npm_package COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/web/test_npm.sh
        $<TARGET_FILE:resolvent_program> ${PROJECT_SOURCE_DIR})
    set_tests_properties(npm_package PROPERTIES LABELS slow SKIP_RETURN_CODE 77)
    # compiles the library by Emscripten first, which takes minutes
    add_test(NAME web_solver COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/web/test_solve.sh
        $<TARGET_FILE:resolvent_program> ${PROJECT_SOURCE_DIR})
    set_tests_properties(web_solver PROPERTIES LABELS long SKIP_RETURN_CODE 77)
endif()
