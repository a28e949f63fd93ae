/// @file check.h
/// Likely mistakes in scenes: common reasons why a picture is not what was expected.
#ifndef RESOLVENT_CHECK_H
#define RESOLVENT_CHECK_H

#include "resolvent/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rsv_mistake {
    RSV_MISTAKE_SCALE,         ///< the scene is tiny or huge: is its unit what its file says?
    RSV_MISTAKE_NO_LIGHT,      ///< nothing shines
    RSV_MISTAKE_BACKS,         ///< a camera sees single-sided surfaces from behind
    RSV_MISTAKE_FLIPPED_FACES, ///< neighbouring faces of an object turn different ways
    RSV_MISTAKE_DOUBLED_FACES, ///< faces lie in the same place
    RSV_MISTAKE_OPEN_SEAMS,    ///< edges of an object lie side by side, but do not share vertices
    RSV_MISTAKE_LEAKS,         ///< a camera in a closed room sees out through gaps
    RSV_MISTAKES
} rsv_mistake;

typedef struct rsv_finding {
    rsv_mistake mistake;
    size_t count;    ///< of faces or edges; 0 where nothing is counted
    double amount;   ///< metres, or a share of a picture; 0 where nothing is measured
    char where[128]; ///< name of an object or a camera; "" = the whole scene
    char text[320];  ///< one line: what, where, what to do
} rsv_finding;

/// A name for programs: "scale", "no_light", "backs", "flipped_faces", ...
RSV_API const char *rsv_mistake_name(rsv_mistake mistake);

/// Looks for mistakes in a committed scene; the same ones for the same scene. Of each kind the worst eight are told.
/// @param findings out: [count], to be released by rsv_findings_release, NULL if there are none
RSV_API rsv_status rsv_scene_check(const rsv_scene *scene, rsv_finding **findings, size_t *count);
RSV_API void rsv_findings_release(const rsv_scene *scene, rsv_finding *findings);

#ifdef __cplusplus
}
#endif

#endif
