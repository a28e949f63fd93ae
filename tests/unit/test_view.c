/// The view without a window: commands, camera, picking and dragging.
#include "light_fixture.h"

#include <stdio.h>

#include "view/view_camera.h"
#include "view/view_keys.h"
#include "view/view_state.h"

/// A box with a lamp and a bulb, solved as coarsely as can be.
typedef struct stage {
    world *w;
    rsv_light *solution;
    rsv_relighter *relighter;
    cli_view_state state;
} stage;

static stage *open_stage(void)
{
    stage *s = calloc(1, sizeof *s);
    s->w = world_begin(1);
    world_room(s->w, world_lambert(s->w, 0.5f, 0), v3(-1, -1, -1), v3(1, 1, 1));
    rsv_material lamp = lambert_material(0, 5);
    lamp.name = "lamp";
    world_quad(s->w, world_material(s->w, lamp), v3(-0.2f, 0.9f, -0.2f), v3(0.2f, 0.9f, -0.2f),
        v3(0.2f, 0.9f, 0.2f), v3(-0.2f, 0.9f, 0.2f));
    rsv_punctual_light bulb = {
        .name = "bulb", .intensity = { 1, 1, 1 }, .position = { 0.5f, 0, 0 }
    };
    rsv_camera camera = rsv_camera_look_at("front", v3(0, 0, 4), v3(0, 0, 0), 0.8f, 1);
    assert_int_equal(rsv_scene_add_light(s->w->scene, &bulb), RSV_OK);
    assert_int_equal(rsv_scene_add_camera(s->w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_commit(s->w->scene), RSV_OK);
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 30;
    desc.rays_per_element = 64;
    assert_int_equal(rsv_light_create(s->w->scene, &desc, &s->solution), RSV_OK);
    assert_int_equal(rsv_relighter_create(s->solution, &s->relighter), RSV_OK);
    assert_true(cli_view_state_begin(
        s->relighter, s->w->scene, 1 + rsv_light_order_count(s->solution), s->w->scene, &s->state));
    s->state.aspect = 1.5f;
    return s;
}

static void close_stage(stage *s)
{
    cli_view_state_free(&s->state);
    rsv_relighter_destroy(s->relighter);
    rsv_light_destroy(s->solution);
    world_end(s->w);
    free(s);
}

/// @return whether the command was carried out
static bool say(stage *s, const char *text)
{
    char problem[CLI_VIEW_TEXT_LENGTH] = "";
    cli_view_command command;
    bool good = cli_read_view_command(text, &command, problem) &&
                cli_view_apply(&s->state, &command, problem);
    assert_int_equal(good, problem[0] == '\0');
    return good;
}

static void all_keys_stand_for_commands(void **state)
{
    (void)state;
    char problem[CLI_VIEW_TEXT_LENGTH];
    cli_view_command command;
    for (size_t k = 0; k < cli_view_key_count; k++)
        if (cli_view_keys[k].command &&
            !cli_read_view_command(cli_view_keys[k].command, &command, problem))
            fail_msg("%s: %s", cli_view_keys[k].key, problem);
}

static void what_is_no_command_is_refused(void **state)
{
    (void)state;
    static const char *const bad[] = { "", "   # nothing", "jump 1", "orbit 1", "orbit 1 2 3",
        "orbit a 2", "orbit 1e30 2", "orbit nan 2", "layer", "albedo wall 1 1", "quit now" };
    char problem[CLI_VIEW_TEXT_LENGTH];
    cli_view_command command;
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        problem[0] = '\0';
        if (cli_read_view_command(bad[k], &command, problem)) fail_msg("'%s' is taken", bad[k]);
        assert_true(strlen(problem) > 0);
    }
    assert_true(cli_read_view_command("select \"light.two words\" # so", &command, problem));
    assert_string_equal(command.text, "light.two words");
}

static void what_is_not_there_cannot_be_changed(void **state)
{
    (void)state;
    static const char *const bad[] = { "select light.moon", "select bulb", "intensity 2",
        "move 0 1 0", "color 1 1 1", "mode magic", "layer 77", "layer 0", "tone loud", "show off",
        "camera nobody", "env-rotate 5", "turn 5", "albedo moon 0 0 0", "albedo lambert 2 0 0" };
    stage *s = open_stage();
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++)
        if (say(s, bad[k])) fail_msg("'%s' is obeyed", bad[k]);
    assert_int_equal(s->state.light_changes, 0);
    assert_true(say(s, "select albedo.lambert"));
    assert_false(say(s, "intensity 2"));
    assert_false(say(s, "move 1 0 0"));
    assert_true(say(s, "select light.bulb"));
    assert_false(say(s, "intensity -1"));
    assert_false(say(s, "color -1 0 0"));
    close_stage(s);
}

static void lights_can_be_added(void **state)
{
    (void)state;
    stage *s = open_stage();
    size_t count = s->state.item_count;
    assert_true(say(s, "add spark 0.1 0.2 0.3"));
    assert_false(say(s, "add spark 0 0 0"));
    assert_int_equal(s->state.selected, count);
    assert_int_equal(cli_view_find_item(&s->state, "light.spark"), count);
    rsv_punctual_light light = cli_view_added_light(&s->state, 0);
    assert_int_equal(rsv_relighter_add_light(s->relighter, &light), RSV_OK);
    assert_true(say(s, "move 0 0.1 0") && say(s, "intensity 2"));
    for (int k = 1; k < CLI_VIEW_MOST_ADDED; k++) {
        char text[CLI_VIEW_TEXT_LENGTH];
        snprintf(text, sizeof text, "add \"spark %d\" 0 0 0", k);
        assert_true(say(s, text));
    }
    assert_false(say(s, "add straw 0 0 0"));
    assert_true(say(s, "reset"));
    assert_true(s->state.item[count].scale == 0);
    close_stage(s);
}

static void orbiting_keeps_the_pivot_in_place(void **state)
{
    (void)state;
    rsv_camera camera = rsv_camera_look_at("c", v3(1, 2, 4), v3(0.3f, 0.1f, 0), 0.9f, 1);
    rsv_vec3 pivot = v3(-0.2f, 0.4f, 0.1f);
    float before[2], after[2];
    float depth = cli_camera_project(&camera, 1.6f, pivot, before);
    for (int k = 0; k < 1000; k++)
        cli_camera_orbit(&camera, pivot, 7.3f, (float)(k % 11) - 5);
    assert_close(cli_camera_project(&camera, 1.6f, pivot, after), depth, 1e-3);
    assert_close(after[0], before[0], 1e-4);
    assert_close(after[1], before[1], 1e-4);
    assert_close(v3_length(camera.right), 1, 1e-5);
    assert_close(v3_dot(camera.right, camera.forward), 0, 1e-5);
    assert_close(v3_length(v3_sub(v3_cross(camera.right, camera.forward), camera.up)), 0, 1e-5);
}

static void nobody_looks_past_the_zenith(void **state)
{
    (void)state;
    rsv_camera camera = rsv_camera_look_at("c", v3(0, 0, 4), v3(0, 0, 0), 0.9f, 1);
    for (int k = 0; k < 300; k++) {
        cli_camera_look(&camera, 1, 3);
        assert_true(camera.up.y > 0);
    }
    for (int k = 0; k < 300; k++) {
        cli_camera_look(&camera, 1, -3);
        assert_true(camera.up.y > 0);
    }
    cli_camera_look(&camera, 0, 45); // and back down again
    assert_true(fabsf(camera.forward.y) < 0.95f);
}

static void a_light_stays_under_the_mouse(void **state)
{
    (void)state;
    stage *s = open_stage();
    size_t bulb = cli_view_find_item(&s->state, "light.bulb");
    float place[2], moved[2];
    char text[CLI_VIEW_TEXT_LENGTH];
    assert_true(say(s, "orbit 30 20"));
    assert_true(cli_view_place(&s->state, &s->state.item[bulb], place) > 0);
    snprintf(text, sizeof text, "pick %g %g", (double)place[0] + 0.005, (double)place[1]);
    assert_true(say(s, text));
    assert_true(s->state.grabbed);
    assert_int_equal(s->state.selected, bulb);
    assert_true(say(s, "drag 0.1 -0.05"));
    cli_view_place(&s->state, &s->state.item[bulb], moved);
    assert_close(moved[0], place[0] + 0.1, 1e-5);
    assert_close(moved[1], place[1] - 0.05, 1e-5);
    assert_true(say(s, "release"));
    rsv_vec3 offset = s->state.item[bulb].offset, position = s->state.camera.position;
    assert_true(say(s, "drag 0.1 0"));
    assert_memory_equal(&offset, &s->state.item[bulb].offset, sizeof offset);
    assert_memory_not_equal(&position, &s->state.camera.position, sizeof position);
    assert_true(say(s, "pick 0.01 0.99"));
    assert_false(s->state.grabbed);
    assert_true(say(s, "look 180 0")); // now it is behind
    assert_false(cli_view_place(&s->state, &s->state.item[bulb], place) > 0);
    close_stage(s);
}

static void changes_reach_the_relighter(void **state)
{
    (void)state;
    stage *s = open_stage();
    rsv_light_scale light[8];
    rsv_albedo_change albedo[8];
    rsv_light_move move[8];
    const cli_view_changes room = { light, albedo, move };
    rsv_relight_desc desc = cli_view_relighting(&s->state, &room);
    assert_int_equal(desc.light_count + desc.albedo_count + desc.move_count + desc.turn, 0);
    assert_true(say(s, "select light.bulb") && say(s, "intensity 2") && say(s, "brighten 1") &&
                say(s, "color 1 0.5 0") && say(s, "move 0.1 0 0") && say(s, "nudge 0 0.2 0") &&
                say(s, "albedo lambert 0.1 0.2 0.3"));
    desc = cli_view_relighting(&s->state, &room);
    assert_int_equal(desc.light_count, 1);
    assert_string_equal(desc.light[0].name, "bulb");
    assert_close(desc.light[0].scale.r, 4, 1e-6);
    assert_close(desc.light[0].scale.g, 2, 1e-6);
    assert_int_equal(desc.move_count, 1);
    assert_close(desc.move[0].offset.y, 0.2, 1e-6);
    assert_int_equal(desc.albedo_count, 1);
    assert_close(desc.albedo[0].base_color.b, 0.3, 1e-6);
    assert_int_equal(rsv_relighter_change(s->relighter, &desc), RSV_OK);
    assert_true(say(s, "reset"));
    desc = cli_view_relighting(&s->state, &room);
    assert_int_equal(desc.light_count + desc.albedo_count + desc.move_count + desc.turn, 0);
    close_stage(s);
}

static void what_the_light_refuses_is_taken_back(void **state)
{
    (void)state;
    stage *s = open_stage();
    assert_true(say(s, "select light.bulb") && say(s, "intensity 2") && say(s, "move 0.1 0 0") &&
                say(s, "add spark 0 0 0"));
    cli_view_note_taken(&s->state);
    cli_view_item taken[16];
    assert_true(s->state.item_count <= 16);
    memcpy(taken, s->state.item, s->state.item_count * sizeof *taken);
    assert_true(say(s, "albedo lambert 1 1 1") && say(s, "select light.bulb") &&
                say(s, "intensity 3") && say(s, "select object") && say(s, "move 0 0.5 0"));
    cli_view_take_back(&s->state);
    for (size_t k = 0; k < s->state.item_count; k++)
        if (k != s->state.object) assert_memory_equal(&taken[k], &s->state.item[k], sizeof *taken);
    assert_close(s->state.item[s->state.object].offset.y, 0.5, 1e-6);
    close_stage(s);
}

/// The largest values that commands accept, repeatedly: the relighter accepts the result, and the camera stays finite.
static void extremes_are_survived(void **state)
{
    (void)state;
    static const char *const words[] = { "orbit 1e6 -1e6", "look 1e6 1e6", "fly 1e6 1e6 -1e6",
        "dolly 1e6", "dolly 1e-6", "dolly 0", "dolly -3", "exposure 1e6", "move 1e6 1e6 1e6",
        "nudge -1e6 0 1e6", "intensity 1e6", "brighten 1e6", "tint 1e6 -1e6 1", "drag 1e6 1e6",
        "pick 0.5 0.5", "drag -1e6 3" };
    stage *s = open_stage();
    rsv_light_scale light[8];
    rsv_albedo_change albedo[8];
    rsv_light_move move[8];
    const cli_view_changes room = { light, albedo, move };
    for (int round = 0; round < 20; round++) {
        assert_true(say(s, "select next"));
        for (size_t k = 0; k < sizeof words / sizeof words[0]; k++)
            say(s, words[k]);
        const rsv_camera *c = &s->state.camera;
        assert_true(isfinite(v3_length(c->position)));
        assert_close(v3_length(c->forward), 1, 1e-4);
        rsv_relight_desc desc = cli_view_relighting(&s->state, &room);
        if (rsv_relighter_change(s->relighter, &desc) != RSV_OK) fail_msg("%s", rsv_last_error());
    }
    close_stage(s);
}

static void layers_and_modes_go_round(void **state)
{
    (void)state;
    stage *s = open_stage();
    for (uint32_t k = 0; k < s->state.layer_count + 1; k++)
        assert_true(say(s, "layer next"));
    assert_int_equal(s->state.layer, RSV_NONE);
    assert_true(say(s, "layer previous"));
    assert_int_equal(s->state.layer, s->state.layer_count - 1);
    assert_true(say(s, "layer 2"));
    assert_int_equal(s->state.layer, 3);
    for (int k = 0; k < CLI_VIEW_MODE_COUNT; k++)
        assert_true(say(s, "mode next"));
    assert_int_equal(s->state.mode, CLI_VIEW_OPERATOR);
    close_stage(s);
}

static void an_object_moves_without_the_light(void **state)
{
    (void)state;
    stage *s = open_stage();
    uint32_t light = s->state.light_changes, object = s->state.object_changes;
    assert_true(say(s, "place 0.1 0.2 -0.3 45"));
    assert_true(say(s, "select object"));
    assert_true(say(s, "nudge 0.1 0 0"));
    const cli_view_item *item = &s->state.item[s->state.object];
    assert_float_equal(item->offset.x, 0.2f, 1e-6f);
    assert_float_equal(item->offset.z, -0.3f, 1e-6f);
    assert_float_equal(s->state.object_turn, 45, 0);
    assert_int_equal(s->state.light_changes, light);
    assert_int_equal(s->state.object_changes, object + 2);
    assert_false(say(s, "intensity 2"));
    assert_false(say(s, "color 1 0 0"));
    assert_true(say(s, "reset"));
    assert_float_equal(s->state.item[s->state.object].offset.x, 0, 0);
    s->state.object = SIZE_MAX;
    assert_false(say(s, "place 0 0 0 0"));
    close_stage(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_keys_stand_for_commands),
        cmocka_unit_test(what_is_no_command_is_refused),
        cmocka_unit_test(what_is_not_there_cannot_be_changed),
        cmocka_unit_test(lights_can_be_added),
        cmocka_unit_test(orbiting_keeps_the_pivot_in_place),
        cmocka_unit_test(nobody_looks_past_the_zenith),
        cmocka_unit_test(a_light_stays_under_the_mouse),
        cmocka_unit_test(changes_reach_the_relighter),
        cmocka_unit_test(what_the_light_refuses_is_taken_back),
        cmocka_unit_test(extremes_are_survived),
        cmocka_unit_test(layers_and_modes_go_round),
        cmocka_unit_test(an_object_moves_without_the_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
