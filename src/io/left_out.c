/// What a build for web pages goes without: formats whose libraries it does not have are refused, each with a message.
#include "image_ktx.h"
#include "scene_read.h"
#include "texture_image.h"

static rsv_status refuse(const char *path, const char *format)
{
    return rsv_fail(RSV_ERROR_UNSUPPORTED,
        "cannot read '%s': %s is not supported in web pages; use PNG or JPEG", path, format);
}

// ---- OpenEXR ----------------------------------------------------------------------------------------

rsv_status rsv_image_decode_exr(rsv_context *context, const rsv_image_file *file, rsv_image **image)
{
    (void)context;
    (void)image;
    return refuse(file->path, "OpenEXR");
}

rsv_status rsv_image_encode_exr(const rsv_image *image, float exposure, rsv_atomic_file *file)
{
    (void)image;
    (void)exposure;
    return rsv_fail(RSV_ERROR_UNSUPPORTED,
        "cannot write '%s': OpenEXR is not supported in web pages; use .hdr or .png", file->target);
}

// ---- WebP -------------------------------------------------------------------------------------------

rsv_status rsv_image_decode_webp(const rsv_image_file *file, rsv_image_codes *codes)
{
    (void)codes;
    return refuse(file->path, "WebP");
}

rsv_status rsv_image_decode_webp_picture(
    rsv_context *context, const rsv_image_file *file, rsv_image **image)
{
    (void)context;
    (void)image;
    return refuse(file->path, "WebP");
}

// ---- KTX --------------------------------------------------------------------------------------------

rsv_status rsv_ktx_decode(
    rsv_context *context, const rsv_image_file *file, rsv_ktx_picture *picture)
{
    (void)context;
    *picture = (rsv_ktx_picture){ 0 };
    return refuse(file->path, "KTX2");
}

void rsv_ktx_free(rsv_context *context, rsv_ktx_picture *picture)
{
    (void)context;
    (void)picture;
}

// ---- files that Assimp reads -------------------------------------------------------------------------

rsv_status rsv_assimp_read(
    const char *path, rsv_file_kind kind, const rsv_load_desc *desc, rsv_scene *scene)
{
    (void)path;
    (void)kind;
    (void)desc;
    (void)scene;
    return rsv_fail(
        RSV_ERROR_UNSUPPORTED, "this format is not supported in web pages; convert it to .glb");
}
