rsv_add_test(bsdf unit/test_bsdf.c)
