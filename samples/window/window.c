/// A baked scene in a window, relit in every frame by the runtime: SDL2 and OpenGL 3.3. Light is in vertices or in a
/// lightmap.
///
///     resolvent bake cornell-blocks -o box.glb --to vertex --basis        (or --to lightmap)
///     window box.glb box.light.safetensors [FRAMES PICTURE.png]
///
/// Left and right select a light; up and down change its strength. Page up and page down turn a sky that was baked with
/// --env-turns. With FRAMES, the last frame is saved as a picture. Base colours come from materials and vertices, not
/// from textures.
#define GL_GLEXT_PROTOTYPES // all that is called here is in libGL itself
#include <SDL.h>
#include <SDL_opengl.h>

#include "glb.h"
#include <resolvent_rt_file.h>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HEIGHT = 512 };

typedef struct viewer {
    SDL_Window *window;
    SDL_GLContext context;
    GLuint program, light_buffer, light_map;
    rsv_rt_file file;
    rsv_rt_basis basis;
    rsv_rt_file_turns turns;
    glb_scene scene;
    float *strength; // [light_count] of each light; of a sky that turns, at its first angle
    float *scale;    // [light_count][3] what the runtime takes
    float *
        irradiance; // [vertex_count or texels][3] receivers first; what has no baked light stays dark
    float turn;     // of the sky, from 0 to 1
    uint32_t chosen, choices;
    int running;
} viewer;

static const char *const vertex_shader = "#version 330\n"
                                         "layout(location = 0) in vec3 position;\n"
                                         "layout(location = 1) in vec3 irradiance;\n"
                                         "layout(location = 2) in vec4 color;\n"
                                         "layout(location = 3) in vec2 place;\n"
                                         "uniform mat4 to_screen;\n"
                                         "out vec4 own_color;\n"
                                         "out vec3 at_vertices;\n"
                                         "centroid out vec2 at_texels;\n"
                                         "void main() {\n"
                                         "    own_color = color;\n"
                                         "    at_vertices = irradiance;\n"
                                         "    at_texels = place;\n"
                                         "    gl_Position = to_screen * vec4(position, 1.0);\n"
                                         "}\n";

// what a diffuse surface shows of irradiance; then codes of sRGB
static const char *const fragment_shader =
    "#version 330\n"
    "in vec4 own_color;\n"
    "in vec3 at_vertices;\n"
    "centroid in vec2 at_texels;\n"
    "uniform sampler2D light_map;\n"
    "uniform bool mapped;\n"
    "uniform vec4 base_color;\n"
    "uniform vec3 emission;\n"
    "uniform float cutoff;\n"
    "out vec4 color;\n"
    "void main() {\n"
    "    vec3 irradiance = mapped ? texture(light_map, at_texels).rgb : at_vertices;\n"
    "    vec4 shown = base_color * own_color * vec4(irradiance / 3.14159265, 1.0);\n"
    "    if (shown.a < cutoff) discard;\n"
    "    vec3 radiance = clamp(shown.rgb + emission, 0.0, 1.0);\n"
    "    vec3 curve = 1.055 * pow(radiance, vec3(1.0 / 2.4)) - 0.055;\n"
    "    color = vec4(mix(curve, 12.92 * radiance, lessThanEqual(radiance, vec3(0.0031308))), "
    "1.0);\n"
    "}\n";

// ---- the window -----------------------------------------------------------------------------------

static int open_window(viewer *v)
{
    if (SDL_Init(SDL_INIT_VIDEO) != 0) return -1;
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_MAJOR_VERSION, 3);
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_MINOR_VERSION, 3);
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_PROFILE_MASK, SDL_GL_CONTEXT_PROFILE_CORE);
    SDL_GL_SetAttribute(SDL_GL_DEPTH_SIZE, 24);
    v->window = SDL_CreateWindow("Resolvent", SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED,
        (int)(HEIGHT * v->scene.aspect + 0.5f), HEIGHT, SDL_WINDOW_OPENGL | SDL_WINDOW_RESIZABLE);
    v->context = v->window ? SDL_GL_CreateContext(v->window) : NULL;
    return v->context ? 0 : -1;
}

static void close_window(viewer *v)
{
    if (v->context) SDL_GL_DeleteContext(v->context);
    if (v->window) SDL_DestroyWindow(v->window);
    SDL_Quit();
}

// ---- what stays on the card -----------------------------------------------------------------------

static void attach_shader(GLuint program, GLenum kind, const char *text)
{
    GLuint shader = glCreateShader(kind);
    glShaderSource(shader, 1, &text, NULL);
    glCompileShader(shader);
    glAttachShader(program, shader);
    glDeleteShader(shader);
}

static GLuint upload(GLenum kind, size_t bytes, const void *data, GLenum usage)
{
    GLuint buffer;
    glGenBuffers(1, &buffer);
    glBindBuffer(kind, buffer);
    glBufferData(kind, (GLsizeiptr)bytes, data, usage);
    return buffer;
}

static void attach_floats(GLuint location, GLint width)
{
    glVertexAttribPointer(location, width, GL_FLOAT, GL_FALSE, 0, NULL);
    glEnableVertexAttribArray(location);
}

/// A texture of floats for the lightmap, to be filled in every frame.
static void create_map(viewer *v)
{
    const GLsizei size[2] = { (GLsizei)v->scene.map_width, (GLsizei)v->scene.map_height };
    glGenTextures(1, &v->light_map);
    glBindTexture(GL_TEXTURE_2D, v->light_map);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB32F, size[0], size[1], 0, GL_RGB, GL_FLOAT, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

/// Places, colours and triangles once; light has a buffer of its own, or a texture, to be filled in every frame.
static int upload_scene(viewer *v)
{
    const glb_scene *s = &v->scene;
    GLuint vertices;
    GLint linked;
    v->program = glCreateProgram();
    attach_shader(v->program, GL_VERTEX_SHADER, vertex_shader);
    attach_shader(v->program, GL_FRAGMENT_SHADER, fragment_shader);
    glLinkProgram(v->program);
    glUseProgram(v->program);
    glGetProgramiv(v->program, GL_LINK_STATUS, &linked);
    glGenVertexArrays(1, &vertices);
    glBindVertexArray(vertices);
    upload(GL_ELEMENT_ARRAY_BUFFER, s->index_count * sizeof *s->index, s->index, GL_STATIC_DRAW);
    upload(GL_ARRAY_BUFFER, s->vertex_count * sizeof *s->position, s->position, GL_STATIC_DRAW);
    attach_floats(0, 3);
    upload(GL_ARRAY_BUFFER, s->vertex_count * sizeof *s->color, s->color, GL_STATIC_DRAW);
    attach_floats(2, 4);
    if (s->map_width > 0) {
        upload(GL_ARRAY_BUFFER, s->vertex_count * sizeof *s->place, s->place, GL_STATIC_DRAW);
        attach_floats(3, 2);
        create_map(v);
    } else {
        v->light_buffer =
            upload(GL_ARRAY_BUFFER, s->vertex_count * 3 * sizeof(float), NULL, GL_STREAM_DRAW);
        attach_floats(1, 3);
    }
    glEnable(GL_DEPTH_TEST);
    return linked ? 0 : -1;
}

// ---- a frame --------------------------------------------------------------------------------------

/// The lights as they are now make the light on everything.
static void relight(viewer *v)
{
    for (uint32_t k = 0; k < 3 * v->basis.light_count; k++)
        v->scale[k] = v->strength[k / 3];
    if (v->turns.count) {
        const float *sky = v->strength + v->turns.first;
        const float color[3] = { *sky, *sky, *sky };
        rsv_rt_turn(v->turn, color, v->turns.count, v->scale + 3 * v->turns.first);
    }
    rsv_rt_relight(
        &v->basis, v->scale, v->basis.light_count, 0, v->basis.receiver_count, v->irradiance);
    const GLsizei size[2] = { (GLsizei)v->scene.map_width, (GLsizei)v->scene.map_height };
    if (v->light_map) {
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size[0], size[1], GL_RGB, GL_FLOAT, v->irradiance);
        return;
    }
    glBindBuffer(GL_ARRAY_BUFFER, v->light_buffer);
    glBufferSubData(GL_ARRAY_BUFFER, 0,
        (GLsizeiptr)(v->scene.vertex_count * 3 * sizeof *v->irradiance), v->irradiance);
}

/// World to screen, column by column: the inverse of the camera's matrix, then perspective.
static void find_projection(const glb_scene *s, int width, int height, float m[16])
{
    const float near = s->nearest, far = s->farthest, *c = s->camera;
    float aspect = (float)width / (float)height; // a narrow window shows all that the camera does
    float y = fminf(1, aspect / s->aspect) / tanf(s->fov / 2), x = y / aspect;
    float depth = (far + near) / (near - far), shift = 2 * far * near / (near - far);
    for (int column = 0; column < 4; column++) {
        float seen[3]; // along the camera's right, up and back
        for (int axis = 0; axis < 3; axis++) {
            const float *a = c + 4 * axis;
            seen[axis] = column < 3 ? a[column] : -(a[0] * c[12] + a[1] * c[13] + a[2] * c[14]);
        }
        m[4 * column] = x * seen[0];
        m[4 * column + 1] = y * seen[1];
        m[4 * column + 2] = depth * seen[2] + (column == 3 ? shift : 0);
        m[4 * column + 3] = -seen[2];
    }
}

static const char *light_name(const viewer *v, uint32_t light)
{
    const char *name = rsv_rt_file_light(&v->file, light);
    return name ? name : "";
}

/// Lamps shine as strongly as their light does; other things that emit shine as baked.
static float lamp_strength(const viewer *v, const glb_part *part)
{
    for (uint32_t l = 0; l < v->basis.light_count; l++)
        if (strcmp(light_name(v, l), part->name) == 0) return v->strength[l];
    return 1;
}

static void draw(const viewer *v)
{
    int width, height;
    float to_screen[16];
    SDL_GL_GetDrawableSize(v->window, &width, &height);
    find_projection(&v->scene, width, height, to_screen);
    glViewport(0, 0, width, height);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glUniformMatrix4fv(glGetUniformLocation(v->program, "to_screen"), 1, GL_FALSE, to_screen);
    for (uint32_t p = 0; p < v->scene.part_count; p++) {
        const glb_part *part = &v->scene.part[p];
        const float *e = part->emission, strength = lamp_strength(v, part);
        glUniform4fv(glGetUniformLocation(v->program, "base_color"), 1, part->base_color);
        glUniform1f(glGetUniformLocation(v->program, "cutoff"), part->cutoff);
        glUniform1i(glGetUniformLocation(v->program, "mapped"), part->mapped);
        glUniform3f(glGetUniformLocation(v->program, "emission"), strength * e[0], strength * e[1],
            strength * e[2]);
        glDrawElements(GL_TRIANGLES, (GLsizei)part->count, GL_UNSIGNED_INT,
            (const char *)NULL + part->first * sizeof(uint32_t));
    }
}

static void keep_picture(const viewer *v, const char *path)
{
    int width, height;
    SDL_GL_GetDrawableSize(v->window, &width, &height);
    unsigned char *pixel = malloc(3 * (size_t)width * (size_t)height);
    if (!pixel) return;
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, pixel);
    stbi_flip_vertically_on_write(1);
    stbi_write_png(path, width, height, 3, pixel, 3 * width);
    free(pixel);
}

// ---- keys -----------------------------------------------------------------------------------------

static void press(viewer *v, SDL_Keycode key)
{
    float *strength = &v->strength[v->chosen];
    if (key == SDLK_ESCAPE) v->running = 0;
    if (key == SDLK_LEFT) v->chosen = (v->chosen + v->choices - 1) % v->choices;
    if (key == SDLK_RIGHT) v->chosen = (v->chosen + 1) % v->choices;
    if (key == SDLK_UP) *strength += 0.125f;
    if (key == SDLK_DOWN) *strength = *strength > 0.125f ? *strength - 0.125f : 0;
    if (key == SDLK_PAGEUP) v->turn += 1.0f / 72;
    if (key == SDLK_PAGEDOWN) v->turn -= 1.0f / 72;
    char title[128];
    snprintf(
        title, sizeof title, "%s: %.3g", light_name(v, v->chosen), (double)v->strength[v->chosen]);
    SDL_SetWindowTitle(v->window, title);
}

static void handle_events(viewer *v)
{
    SDL_Event event;
    while (SDL_PollEvent(&event)) {
        if (event.type == SDL_QUIT) v->running = 0;
        if (event.type == SDL_KEYDOWN) press(v, event.key.keysym.sym);
    }
}

// ---- the program ----------------------------------------------------------------------------------

static int load(viewer *v, const char *scene, const char *basis)
{
    if (rsv_rt_file_open(&v->file, basis) || rsv_rt_file_basis(&v->file, &v->basis)) return -1;
    if (v->basis.light_count == 0 || v->basis.value_count != 1) {
        snprintf(v->scene.message, sizeof v->scene.message, "it is no basis of light on surfaces");
        return -1;
    }
    v->turns = rsv_rt_file_find_turns(&v->file, &v->basis);
    v->choices = v->basis.light_count - (v->turns.count ? v->turns.count - 1 : 0);
    v->strength = malloc(v->basis.light_count * sizeof *v->strength);
    v->scale = malloc(v->basis.light_count * 3 * sizeof *v->scale);
    for (uint32_t l = 0; v->strength && l < v->basis.light_count; l++)
        v->strength[l] = 1;
    if (glb_load(&v->scene, scene, v->basis.receiver_count) != 0) return -1;
    uint32_t values = v->scene.map_width ? v->basis.receiver_count : v->scene.vertex_count;
    v->irradiance = calloc(values, 3 * sizeof *v->irradiance);
    return v->strength && v->scale && v->irradiance ? 0 : -1;
}

static const char *what_failed(const viewer *v)
{
    if (v->file.message[0]) return v->file.message;
    if (v->scene.message[0]) return v->scene.message;
    return *SDL_GetError() ? SDL_GetError() : "no light, or no memory for it";
}

int main(int argc, char **argv)
{
    viewer v;
    memset(&v, 0, sizeof v);
    if (argc != 3 && argc != 5) {
        fprintf(stderr, "usage: window SCENE.glb SCENE.light.safetensors [FRAMES PICTURE.png]\n");
        return 2;
    }
    int frames = argc == 5 ? atoi(argv[3]) : 0;
    v.running = load(&v, argv[1], argv[2]) == 0 && open_window(&v) == 0 && upload_scene(&v) == 0;
    int failed = !v.running;
    if (failed) fprintf(stderr, "error: %s\n", what_failed(&v));
    for (int frame = 1; v.running; frame++) {
        handle_events(&v);
        relight(&v);
        draw(&v);
        if (frame == frames) keep_picture(&v, argv[4]);
        SDL_GL_SwapWindow(v.window);
        v.running = v.running && frame != frames;
    }
    close_window(&v);
    glb_free(&v.scene);
    rsv_rt_file_close(&v.file);
    free(v.strength);
    free(v.scale);
    free(v.irradiance);
    return failed;
}
