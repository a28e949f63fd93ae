/// @file check.h
/// Likely mistakes in scenes: common reasons why a picture is not what was expected.
#ifndef RESOLVENT_CHECK_H
#define RESOLVENT_CHECK_H

#include "resolvent/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rsv_mistake {
    RSV_MISTAKE_SCALE,         ///< the scene is tiny or huge; its unit may be wrong
    RSV_MISTAKE_NO_LIGHT,      ///< there is no light
    RSV_MISTAKE_BACKS,         ///< a camera sees single-sided surfaces from behind
    RSV_MISTAKE_FLIPPED_FACES, ///< neighbouring faces of an object have opposite orientations
    RSV_MISTAKE_DOUBLED_FACES, ///< faces are in the same place
    RSV_MISTAKE_OPEN_SEAMS,    ///< edges of an object touch, but do not share vertices
    RSV_MISTAKE_LEAKS,         ///< a camera in a closed room sees the outside through gaps
    RSV_MISTAKES
} rsv_mistake;

typedef struct rsv_finding {
    rsv_mistake mistake;
    size_t count;    ///< faces or edges; 0 if not applicable
    double amount;   ///< metres, or fraction of a picture; 0 if not applicable
    char where[128]; ///< name of an object or a camera; "" = the whole scene
    char text[320];  ///< one line: what, where, what to do
} rsv_finding;

/// A name for programs: "scale", "no_light", "backs", "flipped_faces", ...
RSV_API const char *rsv_mistake_name(rsv_mistake mistake);

/// Finds likely mistakes in a committed scene. The result is deterministic. At most eight findings of each kind are
/// reported, the worst first.
/// @param findings out: [count], or NULL if there are none; free it with rsv_findings_release
RSV_API rsv_status rsv_scene_check(const rsv_scene *scene, rsv_finding **findings, size_t *count);
RSV_API void rsv_findings_release(const rsv_scene *scene, rsv_finding *findings);

#ifdef __cplusplus
}
#endif

#endif
