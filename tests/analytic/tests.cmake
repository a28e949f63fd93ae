add_library(case_file OBJECT analytic/case_file.c)
target_link_libraries(case_file PUBLIC PkgConfig::CJSON PRIVATE rsv_options)
target_compile_definitions(case_file PRIVATE
    RSV_VALIDATION_DEFAULT="${CMAKE_CURRENT_SOURCE_DIR}/validation/cases.json")

add_executable(test_validation
    analytic/case_lens.c
    analytic/case_mesh.c
    analytic/case_probe.c
    analytic/case_receiver.c
    analytic/case_scene.c
    analytic/case_sky.c
    analytic/validation.c
)
target_link_libraries(test_validation PRIVATE rsv_test_support case_file)

# rsv_add_validation(NAME LABELS argument...): some cases in one mode. What `./dev test` runs is labelled slow, for the
# sanitizers do without it; all cases, labelled long, are run by `./dev validate`.
function(rsv_add_validation name labels)
    add_test(NAME validation_${name} COMMAND test_validation ${ARGN})
    # idle threads that spin cost more than they gain where other tests run beside
    set_tests_properties(validation_${name} PROPERTIES LABELS "${labels}" TIMEOUT 1200
        ENVIRONMENT "OMP_WAIT_POLICY=passive")
endfunction()

rsv_add_validation(view_factors slow a.pa a.perp_rect.1 a.perp_rect.2 a.po a.disks.1_1 a.occluded_square.1_1)
rsv_add_validation(furnaces slow b.furnace_box.1_1 b.furnace_box.3 b.furnace_o b.sphere_point.R1)
rsv_add_validation(enclosures slow c.concentric.1_1 c.cube.rho0p5 i.)
rsv_add_validation(direct slow d.p d.s d.di d.rect_light.c d.rect_light.n d.rect_light.blocked_m d.one_bounce.h2 f.i f.m)
rsv_add_validation(environments slow e.)
rsv_add_validation(rooms slow j.cie5p2 j.cie5p3 j.cie5p4.ce j.cie5p6 j.cie5p7 j.cie5p8.cube_points_rho0p5 j.cie5p9.o
    j.cie5p11.o)
rsv_add_validation(reference slow --reference a.po b.furnace_object.g d.s d.di d.rect_light.n c.cube.rho0p5 e.l
    f.i f.mirror_p j.cie5p4.ce)
rsv_add_validation(stored slow --lookup f.interface.n1p33 f.mirror_point.fin f.caustic.n1p33)

rsv_add_validation(all "slow;long" a. b. c. d. e. f. i. j.)
rsv_add_validation(stored_all "slow;long" --lookup f.)
# Left out here, tested above: d.rect_light.blocked_low and f.mirror_area.full. Their polygons are kilometres wide,
# so rays leave them a millimetre off (8 ulp), which the path tracer's small standard errors resolve (0.4 %).
rsv_add_validation(reference_all "slow;long" --reference a.p a.o b.furnace_box.1 b.furnace_object b.sphere_
    c.two_plates.0p5 c.concentric.1_2 c.cube.rho0p5 d.p d.s d.di d.rect_light.c d.rect_light.n d.rect_light.f
    d.rect_light.blocked_m d.rect_light.blocked_h e. f.c f.i f.mirror_area.p f.mirror_p i. j.)

add_executable(test_profiles analytic/profiles.c)
target_link_libraries(test_profiles PRIVATE rsv_test_support case_file)
add_test(NAME profiles COMMAND test_profiles)
