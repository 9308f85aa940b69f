/* A C program reads many patches in one call, welds them, finds records where they are in memory,
 * visits every vertex with its neighbours, and runs a job on a file.
 *
 * The mesh is a tetrahedron that is refined by midpoints: all places and means are exact. */
#include <math.h>
#include <stdlib.h>

#include "check.h"

enum { LEVEL = 3, SIZE = 1 << LEVEL, POINTS = (SIZE + 1) * (SIZE + 2) / 2 };

static plait_store* refined_store(void) {
  plait_store* const store = tetrahedron_store();
  plait_subdivide_options options = PLAIT_SUBDIVIDE_OPTIONS_INIT;
  options.scheme = "midpoint";
  options.levels = LEVEL;
  CHECK_OK(plait_store_subdivide(store, &options));
  return store;
}

static void test_many_patches(void) {
  plait_store* const store = refined_store();
  plait_reader* reader = NULL;
  CHECK_OK(plait_reader_open(store, NULL, &reader));
  const uint32_t faces[3] = {2, 0, 3};
  static float many[3][POINTS][3], one[POINTS][3];
  CHECK_OK(plait_reader_copy_patches(reader, "position", faces, 3, LEVEL, many, sizeof(many)));
  for (int at = 0; at < 3; ++at) {
    plait_view* view = NULL;
    CHECK_OK(plait_reader_read_patch(reader, faces[at], LEVEL, &view));
    CHECK_OK(plait_view_copy(view, "position", one, sizeof(one)));
    CHECK(memcmp(one, many[at], sizeof(one)) == 0);
    plait_view_release(view);
  }
  CHECK_OK(plait_reader_copy_patches(reader, "position", NULL, 0, LEVEL, NULL, 0));
  CHECK_ERROR(plait_reader_copy_patches(reader, "position", faces, 3, LEVEL, many, 12),
              PLAIT_ERROR_INVALID_ARGUMENT, "12 bytes");
  CHECK_ERROR(plait_reader_copy_patches(reader, "position", NULL, 3, LEVEL, many, sizeof(many)),
              PLAIT_ERROR_INVALID_ARGUMENT, "faces");
  CHECK_ERROR(plait_reader_copy_patches(reader, "age", faces, 3, LEVEL, many, sizeof(many)),
              PLAIT_ERROR_NOT_FOUND, "age");

  /* Four faces of a closed surface: V = 2 + F / 2. Equal numbers are equal places. */
  static uint32_t numbers[4][POINTS];
  static float places[4 * POINTS][3], all[4][POINTS][3];
  const uint32_t order[4] = {3, 1, 0, 2};
  uint64_t count = 0;
  CHECK_OK(plait_reader_weld_patches(reader, order, 4, LEVEL, numbers[0], 4 * POINTS, &count));
  CHECK(count == 2 + 2 * SIZE * SIZE);
  CHECK_OK(plait_reader_copy_patches(reader, "position", order, 4, LEVEL, all, sizeof(all)));
  uint64_t seen = 0, wrong = 0;
  for (int patch = 0; patch < 4; ++patch)
    for (int at = 0; at < POINTS; ++at) {
      const uint32_t number = numbers[patch][at];
      wrong += number > seen;
      if (number == seen) memcpy(places[seen++], all[patch][at], sizeof(places[0]));
      wrong += memcmp(places[number], all[patch][at], sizeof(places[0])) != 0;
    }
  CHECK(seen == count && wrong == 0);
  /* All triangles of the surface: each edge once in each direction, so its ends cancel out. */
  static uint32_t triangles[4 * SIZE * SIZE][3];
  uint64_t triangle_count = 0, sum = 0;
  CHECK_OK(plait_store_get_triangles(store, LEVEL, triangles[0], 4 * SIZE * SIZE, &triangle_count));
  CHECK(triangle_count == 4 * SIZE * SIZE);
  for (uint64_t at = 0; at < triangle_count; ++at)
    for (int corner = 0; corner < 3; ++corner) {
      const uint64_t a = triangles[at][corner], b = triangles[at][(corner + 1) % 3];
      wrong += a >= count || a == b;
      sum += a * a * b - b * b * a;
    }
  CHECK(wrong == 0 && sum == 0);
  CHECK_ERROR(plait_store_get_triangles(store, LEVEL, triangles[0], 4 * SIZE * SIZE - 1, NULL),
              PLAIT_ERROR_INVALID_ARGUMENT, "capacity");
  CHECK_ERROR(plait_store_get_triangles(store, LEVEL + 1, triangles[0], 4, NULL),
              PLAIT_ERROR_INVALID_ARGUMENT, "level");
  const uint32_t twice[2] = {1, 1}, beyond[1] = {4};
  CHECK_ERROR(plait_reader_weld_patches(reader, twice, 2, LEVEL, numbers[0], 2 * POINTS, &count),
              PLAIT_ERROR_INVALID_ARGUMENT, "face 1 is named twice");
  CHECK_ERROR(plait_reader_weld_patches(reader, beyond, 1, LEVEL, numbers[0], POINTS, &count),
              PLAIT_ERROR_INVALID_ARGUMENT, "below 4");
  CHECK_ERROR(plait_reader_weld_patches(reader, order, 4, LEVEL, numbers[0], POINTS, &count),
              PLAIT_ERROR_INVALID_ARGUMENT, "room");
  CHECK_ERROR(plait_reader_weld_patches(reader, order, 4, 17, numbers[0], POINTS, &count),
              PLAIT_ERROR_INVALID_ARGUMENT, "level 17");
  plait_reader_close(reader);
  CHECK_OK(plait_store_close(store));
}

static void test_records_in_place(void) {
  plait_store* const store = refined_store();
  plait_reader* reader = NULL;
  CHECK_OK(plait_reader_open(store, NULL, &reader));
  uint64_t firsts[8] = {9}, blocks = 0, pinned = 0;
  CHECK_OK(plait_reader_get_blocks(reader, "position", LEVEL, firsts, 8, &blocks));
  CHECK(blocks >= 1 && firsts[0] == 0);
  CHECK_ERROR(plait_reader_get_blocks(reader, "position", LEVEL, firsts, 0, &blocks),
              PLAIT_ERROR_INVALID_ARGUMENT, "room");
  static float copied[20][3];
  CHECK_OK(plait_reader_read_vertices(reader, "position", LEVEL, 5, 20, copied, sizeof(copied)));
  plait_pin* pin = NULL;
  const void* records = NULL;
  CHECK_OK(plait_reader_pin_vertices(reader, "position", LEVEL, 5, 20, &pin, &records, &pinned));
  CHECK(pinned == 20 && memcmp(records, copied, sizeof(copied)) == 0);
  CHECK_ERROR(plait_reader_pin_vertices(reader, "position", LEVEL, 5, 0, &pin, &records, &pinned),
              PLAIT_ERROR_INVALID_ARGUMENT, "1 or more");
  uint64_t views = 0;
  CHECK_OK(plait_reader_view_count(reader, &views));
  CHECK(views == 1);
  plait_reader_close(reader);
  CHECK_ERROR(plait_store_close(store), PLAIT_ERROR_BUSY, "1 open view");
  plait_store_release(store);
  CHECK(memcmp(records, copied, sizeof(copied)) == 0); /* the pin keeps the records */
  plait_pin_release(pin);
  plait_pin_release(NULL);
}

typedef struct means {
  uint64_t vertices, neighbours, batches;
} means;

/* In a flat patch the six neighbours of a vertex lie around it: their mean is the vertex itself. */
static int visit_means(const plait_vertex_batch* batch, void* user) {
  means* const found = user;
  CHECK(batch->attribute_count == 2 && batch->border == 0 && batch->valence >= 3);
  CHECK(batch->base == (batch->valence == 3));
  const float(*own)[3] = batch->attributes[0].records;
  const float* next = batch->attributes[0].neighbours;
  float* const lengths = batch->attributes[1].records;
  CHECK(batch->attributes[1].neighbours == NULL);
  for (uint64_t at = 0; at < batch->count; ++at) {
    double mean[3] = {0, 0, 0};
    CHECK(lengths[at] == 0);
    for (int k = 0; k < batch->valence; ++k)
      for (int axis = 0; axis < 3; ++axis) mean[axis] += (double)*next++;
    double length = 0;
    for (int axis = 0; axis < 3; ++axis)
      length += fabs(mean[axis] / batch->valence - (double)own[at][axis]);
    lengths[at] = (float)length;
  }
  found->vertices += batch->count;
  found->neighbours += batch->count * (uint64_t)batch->valence;
  ++found->batches;
  return 1;
}

static int cancel_batch(const plait_vertex_batch* batch, void* user) {
  (void)batch, (void)user;
  return 0;
}

static void test_visit(void) {
  plait_store* const store = refined_store();
  CHECK_OK(plait_store_add_attribute(store, "distance", PLAIT_FLOAT32, 1, LEVEL));
  const plait_visit_attribute attributes[2] = {{"position", PLAIT_ACCESS_READ, 1},
                                               {"distance", PLAIT_ACCESS_OVERWRITE, 0}};
  means found = {0, 0, 0};
  CHECK_OK(
      plait_store_visit(store, attributes, 2, 0, PLAIT_FINEST_LEVEL, visit_means, NULL, &found));
  const uint64_t vertices = 2 + 2 * SIZE * SIZE;
  CHECK(found.vertices == vertices && found.neighbours == 3 * (vertices - 2) * 2);
  plait_reader* reader = NULL;
  CHECK_OK(plait_reader_open(store, NULL, &reader));
  static float patch[POINTS];
  const uint32_t face = 1;
  CHECK_OK(plait_reader_copy_patches(reader, "distance", &face, 1, LEVEL, patch, sizeof(patch)));
  int at = 0, wrong = 0;
  for (int j = 0; j <= SIZE; ++j)
    for (int i = 0; i + j <= SIZE; ++i, ++at) {
      const int inside = i > 0 && j > 0 && i + j < SIZE;
      wrong += inside ? patch[at] != 0 : !(patch[at] > 0);
    }
  CHECK(wrong == 0);
  plait_reader_close(reader);

  const plait_visit_attribute rings[1] = {{"distance", PLAIT_ACCESS_UPDATE, 1}};
  CHECK_ERROR(plait_store_visit(store, rings, 1, 0, PLAIT_FINEST_LEVEL, visit_means, NULL, &found),
              PLAIT_ERROR_INVALID_ARGUMENT, "writes to another one");
  CHECK_ERROR(plait_store_visit(store, attributes, 2, 0, -2, visit_means, NULL, &found),
              PLAIT_ERROR_INVALID_ARGUMENT, "level");
  CHECK_ERROR(plait_store_visit(store, attributes, 2, -1, 1, visit_means, NULL, &found),
              PLAIT_ERROR_INVALID_ARGUMENT, "first_level");
  CHECK_ERROR(plait_store_visit(store, attributes, 2, 2, 1, visit_means, NULL, &found),
              PLAIT_ERROR_INVALID_ARGUMENT, "expected a first level of 1 or less");
  CHECK_ERROR(plait_store_visit(store, attributes, 2, 0, 1, cancel_batch, NULL, NULL),
              PLAIT_ERROR_CANCELLED, "visit");
  CHECK_ERROR(plait_store_commit(store), PLAIT_ERROR_BAD_STATE, "distance");
  CHECK_OK(plait_store_close(store));
}

static int note_phase(const char* phase, uint64_t done, uint64_t total, void* user) {
  CHECK(done <= total);
  if (strcmp(phase, "commit") == 0) ++*(int*)user;
  return 1;
}

static int cancel_work(const char* phase, uint64_t done, uint64_t total, void* user) {
  (void)phase, (void)done, (void)total, (void)user;
  return 0;
}

/* Runs a job with these options, which end with NULL. Returns the report, which the caller ends. */
static plait_status run(const char* job, const char* const* options, plait_progress progress,
                        void* user, plait_text** report) {
  uint64_t count = 0;
  while (options[count] != NULL) ++count;
  return plait_job_run(job, options, count, progress, NULL, user, report);
}

/* Whether a report has this member. */
static int says(const plait_text* report, const char* name, const char* value) {
  char member[128];
  snprintf(member, sizeof(member), "\"%s\":%s", name, value);
  return strstr(plait_text_string(report), member) != NULL;
}

static void test_conversion(const char* path, const char* digest) {
  char input[512], output[512], quoted[64];
  snprintf(input, sizeof(input), "input=%s", path);
  snprintf(output, sizeof(output), "output=%s.copy", path);
  /* The test may have run before. */
  const char* options[] = {input, output, "backend=pread", "verify", "force", NULL, NULL};
  CHECK_ERROR(run("convert", options, cancel_work, NULL, NULL), PLAIT_ERROR_CANCELLED, "");
  plait_text* report = NULL;
  CHECK_OK(run("convert", options, NULL, NULL, &report));
  snprintf(quoted, sizeof(quoted), "\"%s\"", digest);
  CHECK(says(report, "digest", quoted) && !says(report, "stored_bytes", "0"));
  plait_text_release(report);
  snprintf(output, sizeof(output), "output=%s", path);
  CHECK_ERROR(run("convert", options, NULL, NULL, NULL), PLAIT_ERROR_INVALID_ARGUMENT, "the same");
  options[5] = "resume";
  CHECK_ERROR(run("convert", options, NULL, NULL, NULL), PLAIT_ERROR_INVALID_ARGUMENT, "max-error");
  options[5] = "threads=1025";
  CHECK_ERROR(run("convert", options, NULL, NULL, NULL), PLAIT_ERROR_INVALID_ARGUMENT, "threads");
  options[5] = "force";
  CHECK_ERROR(run("convert", options, NULL, NULL, NULL), PLAIT_ERROR_INVALID_ARGUMENT, "twice");
  options[1] = NULL;
  CHECK_ERROR(run("convert", options, NULL, NULL, NULL), PLAIT_ERROR_INVALID_ARGUMENT, "output");
  CHECK_ERROR(plait_job_run("convert", NULL, 1, NULL, NULL, NULL, NULL),
              PLAIT_ERROR_INVALID_ARGUMENT, "options");
  CHECK_ERROR(run(NULL, options, NULL, NULL, NULL), PLAIT_ERROR_INVALID_ARGUMENT, "job");
  CHECK_ERROR(run("copy", options, NULL, NULL, NULL), PLAIT_ERROR_INVALID_ARGUMENT, "subdivide");
  CHECK_ERROR(plait_job_options("copy", &report), PLAIT_ERROR_INVALID_ARGUMENT, "subdivide");
  CHECK_OK(plait_job_options("convert", &report));
  CHECK(says(report, "name", "\"max-error\""));
  plait_text_release(report);
  CHECK(strcmp(plait_text_string(NULL), "") == 0);
  plait_text_release(NULL);
}

/* `path`: a store that does not exist yet. */
static void test_served_files(void) {
  plait_store* const store = refined_store();
  plait_served* served = NULL;
  CHECK_ERROR(plait_served_open(NULL, NULL, NULL, &served), PLAIT_ERROR_INVALID_ARGUMENT, "store");
  CHECK_ERROR(plait_served_open(store, cancel_work, NULL, &served), PLAIT_ERROR_CANCELLED, "view");
  CHECK_OK(plait_served_open(store, NULL, NULL, &served));
  plait_served_file file = PLAIT_SERVED_FILE_INIT;
  CHECK_OK(plait_served_find(served, "/view", &file));
  CHECK(strcmp(file.content_type, "application/octet-stream") == 0 && strlen(file.tag) == 16);
  char begin[8];
  CHECK_OK(plait_served_read(served, "/view", 0, begin, 8));
  CHECK(memcmp(begin, "plaitvew", 8) == 0);
  CHECK_ERROR(plait_served_read(served, "/view", file.bytes - 7, begin, 8),
              PLAIT_ERROR_INVALID_ARGUMENT, "the file has");
  CHECK_ERROR(plait_served_read(served, "/view", UINT64_MAX, begin, 8),
              PLAIT_ERROR_INVALID_ARGUMENT, "the file has");
  CHECK_ERROR(plait_served_find(served, "/manifest", &file), PLAIT_ERROR_NOT_FOUND, "/manifest");
  CHECK_ERROR(plait_store_add_level(store, "position"), PLAIT_ERROR_BUSY, "reader");
  plait_store_release(store); /* what is served stays */
  CHECK_OK(plait_served_find(served, "/", &file));
  CHECK(strstr(file.content_type, "text/html") == file.content_type);
  plait_served_close(served);
  plait_served_close(NULL);
}

static void test_job(const char* path) {
  char mesh[512];
  snprintf(mesh, sizeof(mesh), "%s.off", path);
  FILE* const file = fopen(mesh, "w");
  CHECK(file != NULL);
  if (file == NULL) return;
  fputs("OFF\n4 4 0\n1 1 1\n1 -1 -1\n-1 1 -1\n-1 -1 1\n3 0 1 2\n3 0 3 1\n3 0 2 3\n3 1 3 2\n", file);
  fclose(file);
  int commits = 0;
  char input[520], output[520], levels[32];
  snprintf(input, sizeof(input), "input=%s", mesh);
  snprintf(output, sizeof(output), "output=%s", path);
  snprintf(levels, sizeof(levels), "levels=%d", LEVEL);
  const char* options[] = {
      input,         output, levels, "scheme=midpoint", "compress=fast", "compress=@1=none",
      "digest=true", NULL,   NULL};
  CHECK_ERROR(run("subdivide", options, cancel_work, NULL, NULL), PLAIT_ERROR_CANCELLED, "");
  plait_store* store = NULL;
  CHECK(plait_store_open(path, NULL, &store) == PLAIT_ERROR_NOT_FOUND);
  plait_text* report = NULL;
  CHECK_OK(run("subdivide", options, note_phase, &commits, &report));
  char number[32];
  snprintf(number, sizeof(number), "%d", 2 + 2 * SIZE * SIZE);
  CHECK(says(report, "vertices", number));
  snprintf(number, sizeof(number), "%d", 4 * SIZE * SIZE);
  CHECK(says(report, "faces", number));
  snprintf(number, sizeof(number), "%d", LEVEL);
  CHECK(says(report, "levels", number) && commits >= 1);
  CHECK_OK(plait_store_open(path, NULL, &store));
  char digest[PLAIT_DIGEST_BYTES];
  CHECK_OK(plait_store_digest(store, PLAIT_ALL_LEVELS, 1, NULL, NULL, digest));
  CHECK(strstr(plait_text_string(report), digest) != NULL);
  plait_text_release(report);
  CHECK_OK(plait_store_close(store));
  CHECK_ERROR(run("subdivide", options, NULL, NULL, NULL), PLAIT_ERROR_INVALID_ARGUMENT,
              "force replaces");
  test_conversion(path, digest);
  options[3] = "scheme=soap";
  options[7] = "force";
  CHECK_ERROR(run("subdivide", options, NULL, NULL, NULL), PLAIT_ERROR_INVALID_ARGUMENT, "soap");
  remove(mesh);
}

int main(int count, char** arguments) {
  if (count != 2) return 2;
  test_many_patches();
  test_records_in_place();
  test_visit();
  test_served_files();
  test_job(arguments[1]);
  return failures();
}
