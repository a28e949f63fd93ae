if(DEFINED ENV{RSV_VALIDATION})
    set(RSV_VALIDATION $ENV{RSV_VALIDATION})
else()
    get_filename_component(RSV_VALIDATION ${PROJECT_SOURCE_DIR}/../shared/validation/cases.json ABSOLUTE)
endif()

add_executable(test_validation
    analytic/case_lens.c
    analytic/case_mesh.c
    analytic/case_probe.c
    analytic/case_receiver.c
    analytic/case_scene.c
    analytic/case_sky.c
    analytic/validation.c
)
target_link_libraries(test_validation PRIVATE rsv_test_support PkgConfig::CJSON)
target_compile_definitions(test_validation PRIVATE RSV_VALIDATION_DEFAULT="${RSV_VALIDATION}")

# rsv_add_validation(NAME argument...): some families of cases in one mode.
function(rsv_add_validation name)
    add_test(NAME validation_${name} COMMAND test_validation ${ARGN})
    # idle threads that spin cost more than they gain where other tests run beside
    set_tests_properties(validation_${name} PROPERTIES LABELS slow SKIP_RETURN_CODE 77 TIMEOUT 600
        ENVIRONMENT "OMP_WAIT_POLICY=passive")
endfunction()

rsv_add_validation(view_factors a.)
rsv_add_validation(furnaces b.)
rsv_add_validation(enclosures c. i.)
rsv_add_validation(direct d. f.)
rsv_add_validation(environments e.)
rsv_add_validation(reference_environments --reference e.)
rsv_add_validation(rooms j.)
# Left out here, tested above: d.rect_light.blocked_low and f.mirror_area.full. Their polygons are kilometres wide,
# so rays leave them a millimetre off (8 ulp), which the path tracer's small standard errors resolve (0.4 %).
rsv_add_validation(reference_direct --reference a.p a.o d.p d.s d.di d.rect_light.c d.rect_light.n
    d.rect_light.f d.rect_light.blocked_m d.rect_light.blocked_h f.mirror_area.p j.)
rsv_add_validation(reference_enclosures --reference b.furnace_box.1 b.furnace_object b.sphere_
    c.two_plates.0p5 c.concentric.1_2 c.cube.rho0p5 i.)

add_executable(test_profiles analytic/profiles.c)
target_link_libraries(test_profiles PRIVATE rsv_test_support PkgConfig::CJSON)
target_compile_definitions(test_profiles PRIVATE RSV_VALIDATION_DEFAULT="${RSV_VALIDATION}")
add_test(NAME profiles COMMAND test_profiles)
set_tests_properties(profiles PROPERTIES SKIP_RETURN_CODE 77)
