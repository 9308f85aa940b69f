/* A C program plans a store in parts, makes the parts and joins them.
 *
 *   parts_test STORE     STORE does not exist yet; the program makes other files beside it */
#include "check.h"

static void write_tetrahedron(const char* path) {
  FILE* const file = fopen(path, "w");
  CHECK(file != NULL);
  if (file == NULL) return;
  for (int at = 0; at < 12; at += 3)
    fprintf(file, "v %g %g %g\n", tetrahedron_positions[at], tetrahedron_positions[at + 1],
            tetrahedron_positions[at + 2]);
  for (int at = 0; at < 12; at += 3)
    fprintf(file, "f %u %u %u\n", tetrahedron_triangles[at] + 1, tetrahedron_triangles[at + 1] + 1,
            tetrahedron_triangles[at + 2] + 1);
  CHECK(fclose(file) == 0);
}

static void digest_of(const char* path, char digest[PLAIT_DIGEST_BYTES]) {
  plait_store* store = NULL;
  CHECK_OK(plait_store_open(path, NULL, &store));
  CHECK_OK(plait_store_digest(store, PLAIT_ALL_LEVELS, 1, NULL, NULL, digest));
  plait_store_close(store);
}

int main(int count, char** arguments) {
  if (count != 2) return 2;
  char mesh[4096], plan[4096], whole[4096];
  snprintf(mesh, sizeof(mesh), "%s.obj", arguments[1]);
  /* Names of their own in each run: nothing here removes directories. */
  long number = 0;
  FILE* taken = NULL;
  do {
    snprintf(plan, sizeof(plan), "%s.%ld.plan", arguments[1], number);
    snprintf(whole, sizeof(whole), "%s.%ld.whole", arguments[1], number);
    ++number;
    if (taken != NULL) fclose(taken);
    taken = fopen(plan, "r");
  } while (taken != NULL);
  write_tetrahedron(mesh);

  plait_parts_request request = PLAIT_PARTS_REQUEST_INIT;
  CHECK_ERROR(plait_parts_plan(&request), PLAIT_ERROR_INVALID_ARGUMENT, "mesh_path");
  request.mesh_path = mesh;
  request.plan_path = plan;
  request.levels = 3;
  request.normals = 1;
  request.parts = 7; /* a tetrahedron has six edges */
  CHECK_ERROR(plait_parts_plan(&request), PLAIT_ERROR_INVALID_ARGUMENT, "7");
  request.parts = 4;
  CHECK_OK(plait_parts_plan(&request));
  CHECK_ERROR(plait_parts_make(plan, 4, NULL), PLAIT_ERROR_INVALID_ARGUMENT, "0 to 3");
  plait_part_options again = PLAIT_PART_OPTIONS_INIT;
  again.again = 1;
  CHECK_OK(plait_parts_make(plan, 1, NULL));
  CHECK_OK(plait_parts_make(plan, 1, &again));
  CHECK_ERROR(plait_parts_join(plan, arguments[1], NULL), PLAIT_ERROR_BAD_STATE, "0,2-3");
  for (uint32_t part = 0; part < 4; ++part) CHECK_OK(plait_parts_make(plan, part, NULL));
  plait_join_options join = PLAIT_JOIN_OPTIONS_INIT;
  join.verify = 1;
  CHECK_OK(plait_parts_join(plan, arguments[1], &join));

  plait_subdivision_request one = PLAIT_SUBDIVISION_REQUEST_INIT;
  one.mesh_path = mesh;
  one.store_path = whole;
  one.levels = 3;
  one.normals = 1;
  CHECK_OK(plait_job_subdivide(&one, NULL));
  char found[PLAIT_DIGEST_BYTES] = "", expected[PLAIT_DIGEST_BYTES] = "";
  digest_of(arguments[1], found);
  digest_of(whole, expected);
  CHECK(strcmp(found, expected) == 0);
  return failures();
}
