rsv_add_test(bsdf unit/test_bsdf.c)
rsv_add_test(light unit/test_light.c)
