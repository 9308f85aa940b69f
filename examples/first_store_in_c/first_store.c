/* examples/first_store_in_c/first_store.c: makes a store of an octahedron, refines it to a smooth
 * surface, and reads one patch.
 *
 *   first_store STORE      makes STORE, a directory that does not exist
 */
#include <stdio.h>
#include <stdlib.h>

#include "plait.h"

/* Ends the program if a call has failed. */
static void check(plait_status status) {
  if (status == PLAIT_OK) return;
  fprintf(stderr, "%s: %s\n", plait_status_name(status), plait_error_message());
  exit(1);
}

/* The library calls it many times; 0 would cancel the work. */
static int show_progress(const char* phase, uint64_t done, uint64_t total, void* user) {
  (void)user;
  if (done == total) printf("the last step was: %s\n", phase);
  return 1;
}

static void make_store(const char* path) {
  const double positions[] = {1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
  const uint32_t triangles[] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                                2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
  plait_store_options options = PLAIT_STORE_OPTIONS_INIT;
  options.budget_bytes = 16 << 20; /* the most memory for blocks */
  plait_store* store = NULL;
  check(plait_store_create(path, positions, 6, triangles, 8, &options, &store));

  plait_subdivide_options work = PLAIT_SUBDIVIDE_OPTIONS_INIT;
  work.levels = 6;
  work.normals = 1;
  work.progress = show_progress;
  check(plait_store_subdivide(store, &work));
  check(plait_store_commit(store));
  check(plait_store_close(store));
}

static void read_patch(const char* path) {
  plait_store* store = NULL;
  plait_reader* reader = NULL;
  plait_view* view = NULL;
  check(plait_store_open(path, NULL, &store)); /* NULL: the default options, for reading */
  check(plait_reader_open(store, NULL, &reader));
  check(plait_reader_read_patch(reader, 0, 6, &view)); /* face 0 at level 6 */

  plait_view_info info = PLAIT_VIEW_INFO_INIT;
  check(plait_view_get_info(view, &info));
  const void* position = NULL;
  check(plait_view_at(view, "position", info.size / 2, 0, &position));
  const float* p = position;
  printf("middle of the first side: %.4f %.4f %.4f\n", (double)p[0], (double)p[1], (double)p[2]);

  uint64_t triangles = 0;
  check(plait_reader_patch_indices(reader, 6, NULL, 0, &triangles));
  printf("a patch has %llu vertices and %llu triangles\n", (unsigned long long)info.vertex_count,
         (unsigned long long)triangles);

  plait_view_release(view); /* before the reader and the store */
  plait_reader_close(reader);
  check(plait_store_close(store));
}

int main(int count, char** arguments) {
  if (count != 2) return puts("first_store STORE"), 2;
  make_store(arguments[1]);
  read_patch(arguments[1]);
  return 0;
}
