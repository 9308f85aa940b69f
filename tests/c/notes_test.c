/* A C program finds its own vertices and triangles again, keeps texts and numbers of faces in a
 * store, reads patches ahead, and hears what a store does. Argument: a store that does not exist.
 */
#include <stdlib.h>

#include "check.h"

/* Two flat squares in a row: four triangles, the second of which is turned, and two vertices that
 * no triangle uses, 0 and 4. */
enum { VERTICES = 8, TRIANGLES = 4 };
static const double positions[3 * VERTICES] = {9, 9, 9, 0, 0, 0, 1, 0, 0, 0, 1, 0,
                                               8, 8, 8, 1, 1, 0, 2, 0, 0, 2, 1, 0};
static const uint32_t triangles[3 * TRIANGLES] = {1, 2, 3, 2, 3, 5, 2, 6, 5, 6, 7, 5};

typedef struct heard_events {
  int opened, committed, evicted, slow;
  uint64_t version;
} log_of_store;

static void keep(const plait_event* event, void* user) {
  log_of_store* const told = user;
  told->opened += event->kind == PLAIT_EVENT_OPENED;
  told->committed += event->kind == PLAIT_EVENT_COMMITTED;
  told->evicted += event->kind == PLAIT_EVENT_EVICTED;
  told->slow += event->kind == PLAIT_EVENT_SLOW_READ;
  if (event->kind == PLAIT_EVENT_COMMITTED) told->version = event->version;
  if (event->kind == PLAIT_EVENT_SLOW_READ) CHECK(strcmp(event->attribute, "position") == 0);
}

static void check_maps(const plait_store* store) {
  plait_input_maps maps = PLAIT_INPUT_MAPS_INIT;
  const uint32_t* faces = NULL;
  const double* base = NULL;
  uint64_t count = 0;
  CHECK_OK(plait_store_get_input_maps(store, &maps));
  CHECK_OK(plait_store_get_faces(store, &faces, &count));
  CHECK_OK(plait_store_get_base_positions(store, &base, &count));
  CHECK(maps.vertex_count == VERTICES - 2 && maps.face_count == TRIANGLES);
  CHECK(maps.input_vertex_count == VERTICES && maps.input_face_count == TRIANGLES);
  for (uint32_t vertex = 0; vertex < maps.vertex_count; ++vertex) {
    const uint32_t input = maps.input_vertices[vertex];
    CHECK(memcmp(base + 3 * vertex, positions + 3 * input, 3 * sizeof(double)) == 0);
    CHECK(maps.vertices[input] == vertex);
  }
  CHECK(maps.vertices[0] == UINT32_MAX && maps.vertices[4] == UINT32_MAX);
  int turned = 0;
  for (uint32_t face = 0; face < maps.face_count; ++face) {
    const uint32_t input = maps.input_faces[face];
    turned += maps.turned[face];
    CHECK((maps.turned[face] == 1) == (input == 1));
    for (int corner = 0; corner < 3; ++corner) {
      const int there = maps.turned[face] && corner > 0 ? 3 - corner : corner;
      CHECK(maps.input_vertices[faces[3 * face + (uint32_t)corner]] ==
            triangles[3 * input + (uint32_t)there]);
    }
    CHECK(maps.faces[input] == face);
  }
  CHECK(turned == 1);
}

static void check_notes(const plait_store* store) {
  const char* text = NULL;
  CHECK_OK(plait_store_get_text(store, "unit", &text));
  CHECK(strcmp(text, "mm") == 0);
  CHECK_OK(plait_store_get_text_name(store, 0, &text));
  CHECK(strcmp(text, "author") == 0);
  CHECK_ERROR(plait_store_get_text_name(store, 2, &text), PLAIT_ERROR_NOT_FOUND, "below 2");
  CHECK_ERROR(plait_store_get_text(store, "colour", &text), PLAIT_ERROR_NOT_FOUND, "colour");
  plait_attribute_info info = PLAIT_ATTRIBUTE_INFO_INIT;
  CHECK_OK(plait_store_get_face_attribute(store, 0, &info));
  CHECK(strcmp(info.name, "material") == 0 && info.type == PLAIT_UINT16 && info.record_bytes == 2);
  CHECK_ERROR(plait_store_get_face_attribute(store, 1, &info), PLAIT_ERROR_NOT_FOUND, "below 1");
  const void* records = NULL;
  uint64_t count = 0;
  CHECK_OK(plait_store_get_face_records(store, "material", &records, &count));
  CHECK(count == TRIANGLES);
  for (uint64_t face = 0; face < count; ++face)
    CHECK(((const uint16_t*)records)[face] == 300 * (face + 1));
}

/* The positions of a flat mesh that was refined by midpoints are those of the points. */
static void check_points(const plait_store* store, const plait_reader* reader) {
  const uint32_t* faces = NULL;
  const double* base = NULL;
  uint64_t count = 0;
  CHECK_OK(plait_store_get_faces(store, &faces, &count));
  CHECK_OK(plait_store_get_base_positions(store, &base, &count));
  for (int32_t level = 0; level <= 3; ++level) {
    CHECK_OK(plait_reader_vertex_count(reader, level, &count));
    plait_point* const points = malloc(count * sizeof(plait_point));
    float(*const records)[3] = malloc(count * sizeof(*records));
    CHECK_OK(plait_store_get_points(store, level, 0, count, points));
    CHECK_OK(plait_reader_read_vertices(reader, "position", level, 0, count, records,
                                        count * sizeof(*records)));
    for (uint64_t vertex = 0; vertex < count; ++vertex) {
      const plait_point at = points[vertex];
      CHECK(at.size == 1 << level);
      for (int axis = 0; axis < 3; ++axis) {
        const double a = base[3 * faces[3 * at.face] + (uint32_t)axis],
                     b = base[3 * faces[3 * at.face + 1] + (uint32_t)axis],
                     c = base[3 * faces[3 * at.face + 2] + (uint32_t)axis];
        CHECK((double)records[vertex][axis] ==
              a + (b - a) * at.i / at.size + (c - a) * at.j / at.size);
      }
    }
    plait_point one;
    CHECK_OK(plait_store_get_points(store, level, count - 1, 1, &one));
    CHECK(memcmp(&one, points + count - 1, sizeof(one)) == 0);
    CHECK_ERROR(plait_store_get_points(store, level, count, 1, &one), PLAIT_ERROR_INVALID_ARGUMENT,
                "expected numbers below");
    free(points);
    free(records);
  }
}

/* From the last body to the first, on the calling thread. */
static void run_inline(int32_t count, plait_parallel_body body, void* loop, void* user) {
  for (int32_t number = count; number-- > 0;) body(number, loop);
  ++*(int*)user;
}

static void run_none(int32_t count, plait_parallel_body body, void* loop, void* user) {
  (void)count, (void)body, (void)loop, (void)user;
}

static void check_parallel_for(void) {
  char expected[PLAIT_DIGEST_BYTES], found[PLAIT_DIGEST_BYTES];
  int loops = 0;
  for (int turn = 0; turn < 3; ++turn) {
    plait_store_options options = PLAIT_STORE_OPTIONS_INIT;
    options.backend = "memory";
    if (turn == 1) options.parallel_for = run_inline;
    if (turn == 2) options.parallel_for = run_none;
    options.parallel_user = &loops;
    plait_store* store = NULL;
    CHECK_OK(plait_store_create("", positions, VERTICES, triangles, TRIANGLES, &options, &store));
    plait_subdivide_options how = PLAIT_SUBDIVIDE_OPTIONS_INIT;
    how.levels = 3;
    how.threads = 3;
    if (turn == 2) {
      CHECK_ERROR(plait_store_subdivide(store, &how), PLAIT_ERROR_BAD_STATE, "ran 0 bodies");
    } else {
      CHECK_OK(plait_store_subdivide(store, &how));
      CHECK_OK(plait_store_digest(store, PLAIT_ALL_LEVELS, 3, NULL, NULL, turn ? found : expected));
    }
    CHECK_OK(plait_store_close(store));
  }
  CHECK(loops > 1);
  CHECK(strcmp(found, expected) == 0);
}

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  check_parallel_for();
  log_of_store heard = {0, 0, 0, 0, 0};
  plait_store* store = NULL;
  {
    plait_store_options options = PLAIT_STORE_OPTIONS_INIT;
    options.backend = "pread";
    options.layout = "spatial";
    options.durability = PLAIT_DURABILITY_NONE;
    options.event = keep;
    options.event_user = &heard;
    CHECK_OK(
        plait_store_create(argv[1], positions, VERTICES, triangles, TRIANGLES, &options, &store));
    CHECK(heard.opened == 1);
    check_maps(store);
    CHECK_OK(plait_store_set_text(store, "unit", "mm"));
    CHECK_OK(plait_store_set_text(store, "author", "Zo\xc3\xab"));
    CHECK_OK(plait_store_set_text(store, "gone", "x"));
    CHECK_OK(plait_store_set_text(store, "gone", NULL));
    CHECK_ERROR(plait_store_set_text(store, "bad", "\xff"), PLAIT_ERROR_INVALID_ARGUMENT, "UTF-8");
    CHECK_OK(plait_store_add_face_attribute(store, "material", PLAIT_UINT16));
    CHECK_OK(plait_store_add_face_attribute(store, "other", PLAIT_UINT8));
    CHECK_OK(plait_store_remove_face_attribute(store, "other"));
    CHECK_ERROR(plait_store_add_face_attribute(store, "f", 257), PLAIT_ERROR_INVALID_ARGUMENT,
                "found 257");
    void* records = NULL;
    CHECK_OK(plait_store_edit_face_records(store, "material", &records, NULL));
    for (int face = 0; face < TRIANGLES; ++face)
      ((uint16_t*)records)[face] = (uint16_t)(300 * (face + 1));
    plait_subdivide_options how = PLAIT_SUBDIVIDE_OPTIONS_INIT;
    how.scheme = "midpoint";
    how.levels = 3;
    how.threads = 0;
    CHECK_OK(plait_store_subdivide(store, &how));
    CHECK_OK(plait_store_commit(store));
    CHECK(heard.committed == 1 && heard.version == 1);
    CHECK_OK(plait_store_close(store));
  }
  plait_open_options options = PLAIT_OPEN_OPTIONS_INIT;
  options.event = keep;
  options.event_user = &heard;
  options.slow_read_ns = 1;
  CHECK_OK(plait_store_open(argv[1], &options, &store));
  check_maps(store);
  check_notes(store);
  plait_reader* reader = NULL;
  CHECK_OK(plait_reader_open(store, NULL, &reader));
  const uint32_t wanted[] = {0, 1, 2, 3};
  uint64_t begun = 99;
  CHECK_OK(plait_reader_prefetch(reader, wanted, 4, 3, &begun));
  CHECK(begun <= 4);
  CHECK_OK(plait_reader_end_prefetch(reader));
  check_points(store, reader);
  plait_reader_close(reader);
  CHECK_OK(plait_store_close(store));
  CHECK(heard.opened == 2 && heard.slow > 0);
  return failures();
}
