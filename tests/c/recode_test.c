/* A C program encodes the levels of a compressed store anew, and removes attributes.
 *
 *   recode_test STORE     STORE does not exist yet */
#include "check.h"

enum { LEVELS = 4 };

static plait_store* compressed_store(const char* path) {
  plait_store_options options = PLAIT_STORE_OPTIONS_INIT;
  plait_store* store = NULL;
  options.backend = "compressed";
  options.pipeline = "zstd:1";
  CHECK_OK(plait_store_create(path, tetrahedron_positions, 4, tetrahedron_triangles, 4, &options,
                              &store));
  plait_subdivide_options work = PLAIT_SUBDIVIDE_OPTIONS_INIT;
  work.levels = LEVELS;
  work.normals = 1;
  CHECK_OK(plait_store_subdivide(store, &work));
  return store;
}

static void test_recoded_levels_keep_their_records(plait_store* store) {
  char before[PLAIT_DIGEST_BYTES] = "", after[PLAIT_DIGEST_BYTES] = "";
  CHECK_OK(plait_store_digest(store, PLAIT_ALL_LEVELS, 1, NULL, NULL, before));
  CHECK_ERROR(plait_store_recode_attribute(store, "colour", "zstd:1"), PLAIT_ERROR_NOT_FOUND,
              "colour");
  CHECK_ERROR(plait_store_recode_attribute(store, "position", "no-such-codec"),
              PLAIT_ERROR_NOT_SUPPORTED, "no-such-codec");
  CHECK_ERROR(plait_store_recode_attribute(store, "position", NULL), PLAIT_ERROR_INVALID_ARGUMENT,
              "pipeline");
  CHECK_ERROR(plait_store_recode_attribute(store, "position", "zstd:1;@2-1=lz4"),
              PLAIT_ERROR_INVALID_ARGUMENT, "2-1");
  CHECK_OK(plait_store_recode_attribute(store, "position", "hierarchy+shuffle,zstd:1;@1-2=lz4"));
  CHECK_OK(plait_store_recode_attribute(store, "normal", "normals+shuffle,zstd:1"));
  CHECK_OK(plait_store_commit(store));
  CHECK_OK(plait_store_digest(store, PLAIT_ALL_LEVELS, 1, NULL, NULL, after));
  CHECK(before[0] != '\0' && strcmp(before, after) == 0);
}

/* The normals are encoded from the positions, so the positions stay as long as the normals. */
static void test_removed_attributes(plait_store* store) {
  plait_attribute_info info = PLAIT_ATTRIBUTE_INFO_INIT;
  CHECK_ERROR(plait_store_remove_attribute(store, "colour"), PLAIT_ERROR_NOT_FOUND, "colour");
  CHECK_ERROR(plait_store_remove_attribute(store, "position"), PLAIT_ERROR_BAD_STATE,
              "is encoded from its levels");
  CHECK_OK(plait_store_remove_attribute(store, "normal"));
  CHECK_ERROR(plait_store_find_attribute(store, "normal", &info), PLAIT_ERROR_NOT_FOUND, "normal");
  CHECK_OK(plait_store_find_attribute(store, "position", &info));
  CHECK(info.finest_level == LEVELS);
  CHECK_OK(plait_store_commit(store));
}

int main(int count, char** words) {
  if (count != 2) return 2;
  plait_store* const store = compressed_store(words[1]);
  test_recoded_levels_keep_their_records(store);
  test_removed_attributes(store);
  CHECK_OK(plait_store_close(store));
  return failures();
}
