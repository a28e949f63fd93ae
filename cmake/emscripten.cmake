# The library for web pages, compiled by Emscripten (web/solver/build.sh): own hierarchy, no GPU, no cluster. cJSON, zlib and
# meshoptimizer are compiled from the sources in RSV_SOURCES; formats of other libraries are refused with a message
# (src/io/left_out.c).
set(RSV_SOURCES "" CACHE PATH "Folder with the sources of cJSON, zlib and meshoptimizer, in folders of these names")
set(RSV_EMBREE OFF)
# One set of objects for pages with threads and without: without, the linker makes plain instructions of atomic ones.
add_compile_options(-pthread -msimd128 $<$<COMPILE_LANGUAGE:CXX>:-fexceptions>)

file(GLOB zlib_sources ${RSV_SOURCES}/zlib/*.c)
list(FILTER zlib_sources EXCLUDE REGEX "/(gz[a-z]*|infback)[.]c$")
add_library(rsv_page_libraries STATIC ${zlib_sources} ${RSV_SOURCES}/cjson/cJSON.c
    ${RSV_SOURCES}/meshoptimizer/src/indexcodec.cpp ${RSV_SOURCES}/meshoptimizer/src/vertexcodec.cpp
    ${RSV_SOURCES}/meshoptimizer/src/vertexfilter.cpp)
target_compile_options(rsv_page_libraries PRIVATE -w)
# <cjson/cJSON.h>, as where it is installed
file(COPY ${RSV_SOURCES}/cjson/cJSON.h DESTINATION ${CMAKE_BINARY_DIR}/include/cjson)
target_include_directories(rsv_page_libraries SYSTEM PUBLIC ${CMAKE_BINARY_DIR}/include ${RSV_SOURCES}/zlib
    ${RSV_SOURCES}/meshoptimizer/src)

# Headers alone, which come from the system: its own folder of headers must not be searched as a whole.
find_path(RSV_JSON_DIR nlohmann/json.hpp REQUIRED PATHS /usr/include NO_CMAKE_FIND_ROOT_PATH)
find_path(RSV_STB_DIR stb/stb_image.h REQUIRED PATHS /usr/include NO_CMAKE_FIND_ROOT_PATH)
set(NLOHMANN_JSON_INCLUDE_DIR ${CMAKE_BINARY_DIR}/include CACHE PATH "" FORCE)
file(CREATE_LINK ${RSV_JSON_DIR}/nlohmann ${CMAKE_BINARY_DIR}/include/nlohmann SYMBOLIC)
file(CREATE_LINK ${RSV_STB_DIR}/stb ${CMAKE_BINARY_DIR}/include/stb SYMBOLIC)

function(rsv_leave_out target)
    get_target_property(sources ${target} SOURCES)
    list(FILTER sources EXCLUDE REGEX "^io/(assimp_.*|image_exr.*|image_ktx|image_webp|child_process|gltf_draco)[.](c|cpp)$")
    set_target_properties(${target} PROPERTIES SOURCES "${sources}")
    target_sources(${target} PRIVATE io/left_out.c io/left_out_draco.cpp)
    target_compile_definitions(${target} PRIVATE RSV_WITHOUT_OPENEXR)
    target_link_libraries(${target} PRIVATE rsv_page_libraries)
endfunction()
