/* A C program plans a store in parts, makes the parts and joins them; then a pass of the library
 * and one of its own, in parts and in one process.
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

/* Twice the first coordinate of each vertex and the sum of those of its neighbours. */
static int fold(const plait_vertex_batch* batch, void* user) {
  (void)user;
  const float* const position = batch->attributes[0].records;
  const float* const neighbours = batch->attributes[0].neighbours;
  float* const into = batch->attributes[1].records;
  for (uint64_t i = 0; i < batch->count; ++i) {
    into[i] = 2 * position[3 * i];
    for (int32_t k = 0; k < batch->valence; ++k)
      into[i] += neighbours[3 * (i * (uint64_t)batch->valence + (uint64_t)k)];
  }
  return 1;
}
static plait_status make_fold(plait_store* store, const char* into, void* user) {
  ++*(int*)user;
  const plait_visit_attribute attributes[] = {{"position", PLAIT_ACCESS_READ, 1},
                                              {into, PLAIT_ACCESS_OVERWRITE, 0}};
  return plait_store_visit(store, attributes, 2, 0, PLAIT_FINEST_LEVEL, fold, NULL, NULL);
}
static plait_status fail(plait_store* store, const char* into, void* user) {
  (void)into;
  (void)user;
  return plait_store_visit(store, NULL, 0, 0, PLAIT_FINEST_LEVEL, NULL, NULL, NULL);
}

/* Makes a pass of a plan over `sharded` in parts. */
static void pass_in_parts(const char* sharded, const char* plan, plait_pass_request* request,
                          plait_part_options* options) {
  request->store_path = sharded;
  request->plan_path = plan;
  CHECK_OK(plait_pass_plan(request));
  CHECK_ERROR(plait_parts_join(plan, sharded, NULL), PLAIT_ERROR_BAD_STATE, "0-3");
  for (uint32_t part = 0; part < 4; ++part) CHECK_OK(plait_parts_make(plan, part, options));
  CHECK_OK(plait_parts_join(plan, sharded, NULL));
}

static void check_passes(const char* sharded, const char* whole, const char* plan) {
  char path[4200];
  plait_pass_request request = PLAIT_PASS_REQUEST_INIT;
  CHECK_ERROR(plait_pass_plan(&request), PLAIT_ERROR_INVALID_ARGUMENT, "store_path");
  snprintf(path, sizeof(path), "%s.smooth", plan);
  request.store_path = whole;
  request.plan_path = path;
  CHECK_ERROR(plait_pass_plan(&request), PLAIT_ERROR_INVALID_ARGUMENT, "name");
  request.name = "smooth";
  CHECK_ERROR(plait_pass_plan(&request), PLAIT_ERROR_NOT_SUPPORTED, "in one piece");
  char before[PLAIT_DIGEST_BYTES] = "", found[PLAIT_DIGEST_BYTES] = "";
  digest_of(sharded, before);
  request.factor = 0;
  pass_in_parts(sharded, path, &request, NULL);
  digest_of(sharded, found);
  CHECK(strcmp(found, before) == 0); /* by a factor of 0 nothing moves */

  request.name = "fold";
  request.result = "folded";
  request.components = 1;
  request.parameters = "2 1";
  snprintf(path, sizeof(path), "%s.fold", plan);
  int calls = 0;
  plait_part_options options = PLAIT_PART_OPTIONS_INIT;
  options.kernel = make_fold;
  options.kernel_user = &calls;
  pass_in_parts(sharded, path, &request, &options);
  CHECK(calls == 4);
  options.again = 1;
  CHECK_ERROR(plait_parts_make(path, 0, &options), PLAIT_ERROR_BAD_STATE, "version");
  snprintf(path, sizeof(path), "%s.again", plan);
  request.plan_path = path;
  CHECK_OK(plait_pass_plan(&request));
  CHECK_ERROR(plait_parts_make(path, 0, NULL), PLAIT_ERROR_INVALID_ARGUMENT, "kernel");
  options.kernel = fail;
  CHECK_ERROR(plait_parts_make(path, 0, &options), PLAIT_ERROR_INVALID_ARGUMENT, "kernel");

  plait_store* store = NULL;
  plait_open_options writable = PLAIT_OPEN_OPTIONS_INIT;
  writable.writable = 1;
  CHECK_OK(plait_store_open(whole, &writable, &store));
  CHECK_OK(plait_store_add_attribute(store, "folded", PLAIT_FLOAT32, 1, 3));
  CHECK_OK(make_fold(store, "folded", &calls));
  CHECK_OK(plait_store_commit(store));
  CHECK_OK(plait_store_close(store));
  digest_of(sharded, found);
  digest_of(whole, before);
  CHECK(strcmp(found, before) == 0);
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
  check_passes(arguments[1], whole, plan);
  return failures();
}
