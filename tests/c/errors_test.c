/* Each way in which a call of the C interface can fail, and what it leaves behind. */
#include "check.h"

static const char* store_path; /* a directory that does not exist */

static plait_store* subdivided_store(void) {
  plait_store* const store = tetrahedron_store();
  plait_subdivide_options options = PLAIT_SUBDIVIDE_OPTIONS_INIT;
  options.levels = 2;
  CHECK_OK(plait_store_subdivide(store, &options));
  return store;
}

static const plait_visit_attribute positions = {"position", PLAIT_ACCESS_UPDATE, 0};

static int refuse_batch(const plait_vertex_batch* batch, void* user) {
  (void)batch, (void)user;
  return 0;
}

static void test_null(void) {
  const plait_status refused = PLAIT_ERROR_INVALID_ARGUMENT;
  plait_store* store = NULL;
  plait_reader* reader = NULL;
  plait_view* view = NULL;
  CHECK_ERROR(
      plait_store_create(NULL, tetrahedron_positions, 4, tetrahedron_triangles, 4, NULL, &store),
      refused, "'path'");
  CHECK_ERROR(plait_store_create("x", NULL, 4, tetrahedron_triangles, 4, NULL, &store), refused,
              "'positions'");
  CHECK_ERROR(plait_store_create("x", tetrahedron_positions, 4, NULL, 4, NULL, &store), refused,
              "'triangles'");
  CHECK_ERROR(
      plait_store_create("x", tetrahedron_positions, 4, tetrahedron_triangles, 4, NULL, NULL),
      refused, "'store'");
  CHECK_ERROR(plait_store_create_from_file("x", NULL, NULL, &store), refused, "'mesh_path'");
  CHECK_ERROR(plait_store_open(NULL, NULL, &store), refused, "'path'");
  CHECK_ERROR(plait_store_open("x", NULL, NULL), refused, "'store'");
  CHECK_ERROR(plait_store_commit(NULL), refused, "plait_store_commit: ");
  CHECK_ERROR(plait_store_get_info(NULL, NULL), refused, "'store'");
  CHECK_ERROR(plait_store_subdivide(NULL, NULL), refused, "'store'");
  CHECK_ERROR(plait_store_digest(NULL, 0, 1, NULL, NULL, NULL), refused, "'store'");
  CHECK_ERROR(plait_store_verify(NULL, NULL, NULL, NULL, NULL), refused, "'store'");
  CHECK_ERROR(plait_store_visit(NULL, NULL, 0, 0, 0, NULL, NULL, NULL), refused, "'store'");
  CHECK_ERROR(plait_store_add_attribute(NULL, "a", PLAIT_FLOAT32, 1, 0), refused, "'store'");
  CHECK_ERROR(plait_reader_open(NULL, NULL, &reader), refused, "'store'");
  CHECK_ERROR(plait_reader_read_patch(NULL, 0, 0, &view), refused, "'reader'");
  CHECK_ERROR(plait_view_get_info(NULL, NULL), refused, "'view'");
  CHECK_ERROR(plait_view_copy(NULL, "position", NULL, 0), refused, "'view'");
  CHECK(store == NULL && reader == NULL && view == NULL);

  store = tetrahedron_store();
  CHECK_ERROR(plait_store_get_info(store, NULL), refused, "'info'");
  CHECK_ERROR(plait_store_find_attribute(store, NULL, NULL), refused, "'info'");
  CHECK_ERROR(plait_store_add_level(store, NULL), refused, "'name'");
  CHECK_ERROR(plait_store_visit(store, &positions, 1, 0, 0, NULL, NULL, NULL), refused, "'visit'");
  CHECK_ERROR(plait_store_digest(store, 0, 1, NULL, NULL, NULL), refused, "'text'");
  CHECK_ERROR(plait_reader_open(store, NULL, NULL), refused, "'reader'");
  CHECK_OK(plait_store_close(store));

  CHECK_OK(plait_store_close(NULL));
  plait_store_release(NULL);
  plait_reader_close(NULL);
  plait_view_release(NULL);
}

static void test_plugins(void) {
  CHECK_ERROR(plait_plugin_load(NULL), PLAIT_ERROR_INVALID_ARGUMENT, "'file'");
  CHECK_ERROR(plait_plugin_load("/nonexistent/plugin.so"), PLAIT_ERROR_NOT_FOUND,
              "/nonexistent/plugin.so");
  CHECK_ERROR(plait_plugin_load("/dev/null"), PLAIT_ERROR_INVALID_ARGUMENT, "a regular file");
}

static void test_struct_sizes(void) {
  plait_store* store = NULL;
  plait_open_options opening = PLAIT_OPEN_OPTIONS_INIT;
  opening.struct_size = 0;
  CHECK_ERROR(plait_store_open(store_path, &opening, &store), PLAIT_ERROR_INVALID_ARGUMENT,
              "'struct_size'");
  opening.struct_size = offsetof(plait_open_options, event) - 1; /* of the first version */
  CHECK_ERROR(plait_store_open(store_path, &opening, &store), PLAIT_ERROR_INVALID_ARGUMENT,
              "'struct_size'");
  /* A later version of the structure, whose additional member is 0 or not. */
  struct {
    plait_subdivide_options known;
    uint64_t added;
  } later = {PLAIT_SUBDIVIDE_OPTIONS_INIT, 0};
  later.known.struct_size = sizeof(later);
  store = tetrahedron_store();
  CHECK_OK(plait_store_subdivide(store, &later.known));
  later.added = 1;
  CHECK_ERROR(plait_store_subdivide(store, &later.known), PLAIT_ERROR_NOT_SUPPORTED,
              "does not know");
  plait_store_info info = PLAIT_STORE_INFO_INIT;
  info.struct_size = 8;
  CHECK_ERROR(plait_store_get_info(store, &info), PLAIT_ERROR_INVALID_ARGUMENT, "PLAIT_..._INIT");
  CHECK(info.face_count == 0);
  plait_open_options options = PLAIT_OPEN_OPTIONS_INIT;
  options.reserved = 1;
  plait_store* other = NULL;
  CHECK_ERROR(plait_store_open("none", &options, &other), PLAIT_ERROR_INVALID_ARGUMENT,
              "'reserved'");
  CHECK_OK(plait_store_close(store));
}

static void test_arguments(void) {
  const plait_status refused = PLAIT_ERROR_INVALID_ARGUMENT;
  plait_store* store = NULL;
  const uint32_t bad[3] = {0, 1, 9};
  CHECK_ERROR(plait_store_create(store_path, tetrahedron_positions, 4, bad, 1, NULL, &store),
              refused, "9");
  plait_store_options options = PLAIT_STORE_OPTIONS_INIT;
  options.backend = "cloud";
  CHECK_ERROR(plait_store_create(store_path, tetrahedron_positions, 4, tetrahedron_triangles, 4,
                                 &options, &store),
              PLAIT_ERROR_NOT_SUPPORTED, "pread");
  CHECK_ERROR(plait_store_open(store_path, NULL, &store), PLAIT_ERROR_NOT_FOUND, store_path);
  CHECK(strcmp(plait_error_path(), store_path) == 0);
  store = subdivided_store();
  plait_subdivide_options work = PLAIT_SUBDIVIDE_OPTIONS_INIT;
  work.scheme = "spiral";
  CHECK_ERROR(plait_store_subdivide(store, &work), refused, "butterfly");
  CHECK_ERROR(plait_store_add_attribute(store, "a", 11, 1, 0), refused, "type");
  CHECK_ERROR(plait_store_add_attribute(store, "a", PLAIT_FLOAT32, 0, 0), refused, "components");
  CHECK_ERROR(plait_store_add_attribute(store, "a", PLAIT_FLOAT32, 1, 21), refused, "0 to 20");
  CHECK_ERROR(plait_store_add_attribute(store, "a", PLAIT_FLOAT32, 1, -1), refused, "0 to 20");
  CHECK_ERROR(plait_store_visit(store, &positions, 1, 3, 3, refuse_batch, NULL, NULL), refused,
              "ends at level 2");
  plait_attribute_info info = PLAIT_ATTRIBUTE_INFO_INIT;
  CHECK_ERROR(plait_store_get_attribute(store, 1, &info), PLAIT_ERROR_NOT_FOUND, "below 1");
  CHECK_ERROR(plait_store_find_attribute(store, "normal", &info), PLAIT_ERROR_NOT_FOUND,
              "position");

  plait_reader* reader = NULL;
  plait_view* view = NULL;
  CHECK_OK(plait_reader_open(store, NULL, &reader));
  CHECK_ERROR(plait_reader_read_patch(reader, 4, 2, &view), refused, "below 4");
  CHECK_ERROR(plait_reader_read_patch(reader, 0, 3, &view), refused, "0 to 2");
  CHECK(view == NULL);
  CHECK_OK(plait_reader_read_patch(reader, 3, 2, &view));
  const void* record = NULL;
  float few[3];
  CHECK_ERROR(plait_view_at(view, "position", 3, 2, &record), refused, "(3, 2)");
  CHECK_ERROR(plait_view_at(view, "normal", 0, 0, &record), PLAIT_ERROR_NOT_FOUND, "'normal'");
  CHECK_ERROR(plait_view_copy(view, "position", few, sizeof(few)), refused, "15 records");
  CHECK_ERROR(plait_reader_read_vertices(reader, "position", 1, 0, 2, few, sizeof(few)), refused,
              "2 records of 12 bytes");
  float many[9];
  CHECK_ERROR(plait_reader_read_vertices(reader, "position", 1, 0, 2, many, sizeof(many)), refused,
              "2 records of 12 bytes, found 36");
  CHECK_ERROR(plait_reader_read_vertices(reader, "position", 1, 0, 2, many, 25), refused,
              "2 records of 12 bytes, found 25");
  CHECK_OK(plait_reader_read_vertices(reader, "position", 1, 0, 2, many, 24));
  CHECK_ERROR(plait_reader_read_vertices(reader, "position", 1, 6, 1, few, sizeof(few)), refused,
              "below 6");
  uint32_t indices[48];
  uint64_t count = 0;
  CHECK_ERROR(plait_reader_patch_indices(reader, 2, indices, 15, &count), refused, "16 triangles");
  CHECK_OK(plait_reader_patch_indices(reader, 2, indices, 16, &count));
  CHECK(count == 16);
  const double low[3] = {-9, -9, -9};
  const double high[3] = {9, 9, 9};
  CHECK_ERROR(plait_reader_faces_in_box(reader, NULL, low, high, indices, 3, &count), refused,
              "4 faces, found 3");
  CHECK_OK(plait_reader_faces_in_box(reader, NULL, low, high, indices, 4, &count));
  CHECK(count == 4);
  plait_view_release(view);
  plait_reader_close(reader);
  CHECK_OK(plait_store_close(store));
}

static void test_views_hold_the_store(void) {
  plait_store* store = subdivided_store();
  plait_reader* reader = NULL;
  plait_view* view = NULL;
  uint64_t views = 0;
  CHECK_OK(plait_reader_open(store, NULL, &reader));
  CHECK_OK(plait_reader_read_patch(reader, 0, 2, &view));
  CHECK_OK(plait_reader_view_count(reader, &views));
  CHECK(views == 1);
  CHECK_ERROR(plait_store_close(store), PLAIT_ERROR_BUSY, "1 reader and 1 open view:");
  CHECK_ERROR(plait_store_commit(store), PLAIT_ERROR_BUSY, "reader");
  CHECK_ERROR(plait_store_add_level(store, "position"), PLAIT_ERROR_BUSY, "reader");
  plait_reader_close(reader);
  CHECK_ERROR(plait_store_close(store), PLAIT_ERROR_BUSY, "0 readers and 1 open view:");
  plait_view_release(view);
  CHECK_OK(plait_store_close(store));

  store = subdivided_store(); /* a view may outlive everything else */
  CHECK_OK(plait_reader_open(store, NULL, &reader));
  CHECK_OK(plait_reader_read_patch(reader, 0, 2, &view));
  plait_reader_close(reader);
  plait_store_release(store);
  const void* record = NULL;
  CHECK_OK(plait_view_at(view, "position", 1, 1, &record));
  CHECK(record != NULL);
  plait_view_release(view);
}

static int cancel_third(const char* phase, uint64_t done, uint64_t total, void* user) {
  CHECK(phase[0] != 0 && done <= total);
  return ++*(int*)user < 3;
}

static void test_cancel(void) {
  plait_store* store = tetrahedron_store();
  plait_subdivide_options options = PLAIT_SUBDIVIDE_OPTIONS_INIT;
  int calls = 0;
  options.levels = 6;
  options.executor = "sweep";
  options.progress = cancel_third;
  options.user = &calls;
  CHECK_ERROR(plait_store_subdivide(store, &options), PLAIT_ERROR_CANCELLED, "cancelled");
  CHECK(calls == 3);
  CHECK_ERROR(plait_store_commit(store), PLAIT_ERROR_BAD_STATE, "");
  CHECK_OK(plait_store_close(store));
  store = subdivided_store();
  CHECK_ERROR(plait_store_visit(store, &positions, 1, 2, 2, refuse_batch, NULL, NULL),
              PLAIT_ERROR_CANCELLED, "callback");
  CHECK_ERROR(plait_store_commit(store), PLAIT_ERROR_BAD_STATE, "position");
  CHECK_OK(plait_store_close(store));
}

/* Calls that would take the ground of the work that calls back. */
static void call_back(plait_store* store) {
  const plait_status refused = PLAIT_ERROR_BAD_STATE;
  plait_store_info info = PLAIT_STORE_INFO_INIT;
  CHECK_ERROR(plait_store_close(store), refused, "under way");
  CHECK_ERROR(plait_store_commit(store), refused, "under way");
  CHECK_ERROR(plait_store_roll_back(store), refused, "under way");
  CHECK_ERROR(plait_store_remove_attribute(store, "position"), refused, "under way");
  CHECK_ERROR(plait_store_add_level(store, "position"), refused, "under way");
  CHECK_OK(plait_store_get_info(store, &info));
}

static int call_back_with_progress(const char* phase, uint64_t done, uint64_t total, void* user) {
  (void)phase, (void)done, (void)total;
  call_back((plait_store*)user);
  return 1;
}

static int call_back_with_batch(const plait_vertex_batch* batch, void* user) {
  (void)batch;
  call_back((plait_store*)user);
  return 1;
}

static void test_calls_from_callbacks(void) {
  plait_store* store = tetrahedron_store();
  plait_subdivide_options options = PLAIT_SUBDIVIDE_OPTIONS_INIT;
  options.levels = 3;
  options.progress = call_back_with_progress;
  options.user = store;
  CHECK_OK(plait_store_subdivide(store, &options));
  char digest[PLAIT_DIGEST_BYTES];
  CHECK_OK(plait_store_digest(store, PLAIT_ALL_LEVELS, 1, call_back_with_progress, store, digest));
  CHECK_OK(plait_store_verify(store, call_back_with_progress, NULL, store, NULL));
  for (int32_t level = 0; level <= 1; ++level)
    CHECK_OK(
        plait_store_visit(store, &positions, 1, level, level, call_back_with_batch, NULL, store));
  CHECK_OK(plait_store_close(store));
}

static void test_roll_back(void) {
  plait_store* store = subdivided_store();
  char committed[PLAIT_DIGEST_BYTES], digest[PLAIT_DIGEST_BYTES];
  CHECK_OK(plait_store_commit(store));
  CHECK_OK(plait_store_digest(store, PLAIT_ALL_LEVELS, 1, NULL, NULL, committed));
  CHECK_ERROR(plait_store_visit(store, &positions, 1, 2, 2, refuse_batch, NULL, NULL),
              PLAIT_ERROR_CANCELLED, "callback");
  CHECK_ERROR(plait_store_digest(store, PLAIT_ALL_LEVELS, 1, NULL, NULL, digest),
              PLAIT_ERROR_BAD_STATE, "level 2 of 'position'");
  CHECK_OK(plait_store_roll_back(store));
  CHECK_OK(plait_store_digest(store, PLAIT_ALL_LEVELS, 1, NULL, NULL, digest));
  CHECK(strcmp(committed, digest) == 0);
  CHECK_ERROR(plait_store_roll_back(NULL), PLAIT_ERROR_INVALID_ARGUMENT, "'store'");
  CHECK_OK(plait_store_close(store));
}

static void test_flags(void) {
  const plait_status refused = PLAIT_ERROR_INVALID_ARGUMENT;
  plait_store* store = NULL;
  plait_open_options options = PLAIT_OPEN_OPTIONS_INIT;
  options.writable = 7;
  CHECK_ERROR(plait_store_open(store_path, &options, &store), refused, "writable");
  store = tetrahedron_store();
  plait_subdivide_options work = PLAIT_SUBDIVIDE_OPTIONS_INIT;
  work.normals = 7;
  CHECK_ERROR(plait_store_subdivide(store, &work), refused, "normals");
  CHECK_OK(plait_store_close(store));
}

static void test_store_for_reading(void) {
  plait_store* store = NULL;
  int32_t committed = 1;
  CHECK_OK(plait_store_create(store_path, tetrahedron_positions, 4, tetrahedron_triangles, 4, NULL,
                              &store));
  CHECK_OK(plait_store_has_commit(store_path, &committed));
  CHECK(committed == 0);
  CHECK_OK(plait_store_commit(store));
  plait_subdivide_options work = PLAIT_SUBDIVIDE_OPTIONS_INIT;
  work.levels = 4;
  CHECK_OK(plait_store_subdivide(store, &work));
  CHECK_OK(plait_store_commit(store));
  int calls = 0;
  CHECK_ERROR(plait_store_write_bounds(store, NULL, cancel_third, &calls), PLAIT_ERROR_CANCELLED,
              "plait_store_write_bounds");
  CHECK(calls == 3);
  CHECK_OK(plait_store_write_bounds(store, "position", NULL, NULL));
  CHECK_OK(plait_store_close(store));
  CHECK_OK(plait_store_has_commit(store_path, &committed));
  CHECK(committed == 1);
  CHECK_OK(plait_store_open(store_path, NULL, &store));
  void* records = NULL;
  CHECK_ERROR(plait_store_edit_base_records(store, "position", &records, NULL),
              PLAIT_ERROR_BAD_STATE, "opened for reading");
  CHECK(records == NULL);
  CHECK_ERROR(plait_store_commit(store), PLAIT_ERROR_BAD_STATE, "opened for reading");
  CHECK(strcmp(plait_error_path(), store_path) == 0);
  CHECK_OK(plait_store_close(store));
}

/* errors_test STORE: makes this store, which must not exist. */
int main(int count, char** arguments) {
  if (count != 2) return puts("errors_test STORE"), 2;
  store_path = arguments[1];
  test_null();
  test_plugins();
  test_struct_sizes();
  test_arguments();
  test_views_hold_the_store();
  test_cancel();
  test_calls_from_callbacks();
  test_roll_back();
  test_flags();
  test_store_for_reading();
  return failures();
}
