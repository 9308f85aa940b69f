/* A C program makes a store from arrays, subdivides it, and reads values that it computes itself.
 */
#include <math.h>

#include "check.h"

enum { LEVEL = 4, SIZE = 1 << LEVEL };

static uint64_t tetrahedron_vertices(int level) {
  return 2 + 2 * (UINT64_C(1) << (2 * level)); /* V - E + F = 2 and 3 F = 2 E */
}

/* Midpoint refinement puts (i, j) at the same place of the flat face. All numbers are exact. */
static void check_patch(const plait_store* store, const plait_view* view, uint32_t face) {
  const uint32_t* faces = NULL;
  const double* base = NULL;
  uint64_t count = 0;
  CHECK_OK(plait_store_get_faces(store, &faces, &count));
  CHECK(count == 4);
  CHECK_OK(plait_store_get_base_positions(store, &base, &count));
  CHECK(count == 4);
  const double* const a = base + 3 * faces[3 * face];
  const double* const b = base + 3 * faces[3 * face + 1];
  const double* const c = base + 3 * faces[3 * face + 2];

  static float copy[(SIZE + 1) * (SIZE + 2) / 2][3];
  CHECK_OK(plait_view_copy(view, "position", copy, sizeof(copy)));
  int wrong = 0, at = 0;
  for (int j = 0; j <= SIZE; ++j)
    for (int i = 0; i + j <= SIZE; ++i, ++at) {
      const void* record = NULL;
      CHECK_OK(plait_view_at(view, "position", i, j, &record));
      for (int axis = 0; axis < 3; ++axis) {
        const double expected =
            a[axis] + (b[axis] - a[axis]) * i / SIZE + (c[axis] - a[axis]) * j / SIZE;
        wrong += (double)((const float*)record)[axis] != expected;
        wrong += (double)copy[at][axis] != expected;
      }
    }
  CHECK(wrong == 0);
}

/* The triangles of a flat patch have one area, and together the area of the face. */
static void check_indices(const plait_reader* reader, const plait_view* view) {
  static uint32_t indices[SIZE * SIZE][3];
  static float p[(SIZE + 1) * (SIZE + 2) / 2][3];
  uint64_t count = 0;
  CHECK_OK(plait_reader_patch_indices(reader, LEVEL, NULL, 0, &count));
  CHECK(count == SIZE * SIZE);
  CHECK_OK(plait_reader_patch_indices(reader, LEVEL, indices[0], count, &count));
  CHECK_OK(plait_view_copy(view, "position", p, sizeof(p)));
  double area = 0;
  for (uint64_t triangle = 0; triangle < count; ++triangle) {
    double u[3], v[3];
    for (int axis = 0; axis < 3; ++axis) {
      const float start = p[indices[triangle][0]][axis];
      u[axis] = (double)(p[indices[triangle][1]][axis] - start);
      v[axis] = (double)(p[indices[triangle][2]][axis] - start);
    }
    const double x = u[1] * v[2] - u[2] * v[1], y = u[2] * v[0] - u[0] * v[2];
    const double z = u[0] * v[1] - u[1] * v[0];
    area += sqrt(x * x + y * y + z * z) / 2;
  }
  CHECK(fabs(area - sqrt(3) * 8 / 4) < 1e-9); /* a face has sides of length sqrt(8) */
}

static int count_patch(const plait_view* view, void* user) {
  plait_view_info info = PLAIT_VIEW_INFO_INIT;
  CHECK_OK(plait_view_get_info(view, &info));
  CHECK(info.level == LEVEL && info.size == SIZE &&
        info.vertex_count == (SIZE + 1) * (SIZE + 2) / 2);
  uint32_t* const faces = user;
  *faces = 10 * *faces + info.face;
  return 1;
}

static void test_midpoint_patches(void) {
  plait_store* const store = tetrahedron_store();
  plait_subdivide_options options = PLAIT_SUBDIVIDE_OPTIONS_INIT;
  options.scheme = "midpoint";
  options.levels = LEVEL;
  CHECK_OK(plait_store_subdivide(store, &options));
  CHECK_OK(plait_store_commit(store));
  plait_reader* reader = NULL;
  CHECK_OK(plait_reader_open(store, NULL, &reader));
  for (uint32_t face = 0; face < 4; ++face) {
    plait_view* view = NULL;
    CHECK_OK(plait_reader_read_patch(reader, face, LEVEL, &view));
    check_patch(store, view, face);
    check_indices(reader, view);
    plait_view_release(view);
  }
  const uint32_t order[3] = {2, 0, 3};
  uint32_t visited = 0;
  CHECK_OK(plait_reader_visit_patches(reader, order, 3, LEVEL, count_patch, &visited));
  CHECK(visited == 203);
  const double low[3] = {0.9, 0.9, 0.9}, high[3] = {2, 2, 2}, down[3] = {-1, -1, -1};
  uint32_t near[4] = {9, 9, 9, 9};
  double distances[4] = {9, 9, 9, 9};
  uint64_t found = 0;
  CHECK_OK(plait_reader_faces_in_box(reader, NULL, low, high, near, 4, &found));
  CHECK(found == 4); /* the bounds of each face are those of the tetrahedron */
  for (uint32_t face = 0; face < 4; ++face) CHECK(near[face] == face);
  CHECK_OK(plait_reader_faces_in_box(reader, NULL, high, high, near, 4, &found));
  CHECK(found == 0);
  CHECK_OK(
      plait_reader_faces_along_ray(reader, "position", high, down, near, distances, 4, &found));
  CHECK(found == 4 && distances[0] == 1);
  CHECK(plait_reader_faces_in_box(reader, NULL, low, high, near, 2, &found) ==
        PLAIT_ERROR_INVALID_ARGUMENT);
  CHECK(found == 4); /* as before the call */
  CHECK(plait_reader_faces_in_box(reader, NULL, NULL, high, near, 2, &found) ==
        PLAIT_ERROR_INVALID_ARGUMENT);
  for (int level = 0; level <= LEVEL; ++level) {
    uint64_t created = 0, all = 0, faces = 0;
    CHECK_OK(plait_reader_vertex_count(reader, level, &created));
    CHECK_OK(plait_store_get_counts(store, level, &all, NULL, &faces));
    CHECK(all == tetrahedron_vertices(level) && faces == UINT64_C(4) << (2 * level));
    CHECK(created == all - (level == 0 ? 0 : tetrahedron_vertices(level - 1)));
  }
  plait_reader_close(reader);
  CHECK_OK(plait_store_close(store));
}

/* Loop's rule around the origin: the neighbours of v add up to -v, so v moves to v/4; the middle of
 * an edge (v, w) moves to (v + w)/4. */
static void test_loop_on_a_tetrahedron(void) {
  plait_store* const store = tetrahedron_store();
  CHECK_OK(plait_store_subdivide(store, NULL));
  const void* records = NULL;
  uint64_t count = 0;
  CHECK_OK(plait_store_get_base_records(store, "position", &records, &count));
  const float* const base = records;
  CHECK(count == 4);
  for (uint64_t vertex = 0; vertex < count; ++vertex)
    for (uint64_t axis = 0; axis < 3; ++axis)
      CHECK(fabs((double)base[3 * vertex + axis] - tetrahedron_positions[3 * vertex + axis] / 4) <
            1e-6);
  plait_reader* reader = NULL;
  float odd[6][3];
  CHECK_OK(plait_reader_open(store, NULL, &reader));
  CHECK_OK(plait_reader_read_vertices(reader, "position", 1, 0, 6, odd, sizeof(odd)));
  for (int vertex = 0; vertex < 6; ++vertex) { /* (v + w)/4 has length 1/2, along an axis */
    const double sum =
        fabs((double)odd[vertex][0]) + fabs((double)odd[vertex][1]) + fabs((double)odd[vertex][2]);
    CHECK(fabs(sum - 0.5) < 1e-6);
  }
  plait_reader_close(reader);
  CHECK_OK(plait_store_close(store));
}

static int write_numbers(const plait_vertex_batch* batch, void* user) {
  uint32_t* const numbers = batch->attributes[0].records;
  for (uint64_t at = 0; at < batch->count; ++at) numbers[at] = (uint32_t)batch->places[at];
  *(uint64_t*)user += batch->count;
  return 1;
}

static int add_seven(const plait_vertex_batch* batch, void* user) {
  uint32_t* const numbers = batch->attributes[0].records;
  for (uint64_t at = 0; at < batch->count; ++at) {
    CHECK(batch->levels[at] == *(const int*)user);
    numbers[at] += 7;
  }
  return 1;
}

static int check_numbers(const void* records, uint64_t first, uint64_t count, void* user) {
  for (uint64_t at = 0; at < count; ++at)
    CHECK(((const uint32_t*)records)[at] == (uint32_t)(first + at + 7));
  ++*(int*)user;
  return 1;
}

static void test_own_attribute(void) {
  enum { FINEST = 6 };
  plait_store* const store = tetrahedron_store();
  CHECK_OK(plait_store_add_attribute(store, "number", PLAIT_UINT32, 1, FINEST));
  plait_attribute_info info = PLAIT_ATTRIBUTE_INFO_INIT;
  CHECK_OK(plait_store_find_attribute(store, "number", &info));
  CHECK(info.index == 1 && info.finest_level == FINEST && info.record_bytes == 4);
  const char* const names[] = {"number"};
  plait_reader_options options = PLAIT_READER_OPTIONS_INIT;
  options.attributes = names;
  options.attribute_count = 1;
  const plait_visit_attribute overwritten = {"number", PLAIT_ACCESS_OVERWRITE, 0};
  const plait_visit_attribute updated = {"number", PLAIT_ACCESS_UPDATE, 0};
  for (int level = 0; level <= FINEST; ++level) {
    uint64_t written = 0, count = 0;
    CHECK_OK(
        plait_store_visit(store, &overwritten, 1, level, level, write_numbers, NULL, &written));
    CHECK_OK(plait_store_visit(store, &updated, 1, level, level, add_seven, NULL, &level));
    plait_reader* reader = NULL;
    CHECK_OK(plait_reader_open(store, &options, &reader));
    CHECK_OK(plait_reader_vertex_count(reader, level, &count));
    CHECK(written == count);
    /* A pass over one level leaves the coarser ones as they are. */
    for (int coarser = 0; coarser <= level; ++coarser) {
      int blocks = 0;
      CHECK_OK(plait_reader_vertex_count(reader, coarser, &count));
      CHECK_OK(
          plait_reader_visit_vertices(reader, "number", coarser, 0, count, check_numbers, &blocks));
      CHECK(blocks >= 1);
      CHECK(coarser != FINEST || blocks == 6); /* 4096 bytes are one slot of level 6 */
    }
    uint32_t last[2] = {0, 0};
    CHECK_OK(plait_reader_read_vertices(reader, "number", level, count - 2, 2, last, sizeof(last)));
    CHECK(last[0] == count + 5 && last[1] == count + 6);
    plait_reader_close(reader);
  }
  CHECK_OK(plait_store_commit(store));
  CHECK_OK(plait_store_close(store));
}

int main(void) {
  test_midpoint_patches();
  test_loop_on_a_tetrahedron();
  test_own_attribute();
  return failures();
}
