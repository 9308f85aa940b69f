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

/* Runs a job with these options, of which the last is NULL; `plan` is "plan=...", and `first`
 * another one, or NULL. */
static plait_status run(const char* job, const char* first, const char* plan,
                        const char* const* options) {
  const char* all[16];
  uint64_t count = 0;
  if (first != NULL) all[count++] = first;
  all[count++] = plan;
  for (uint64_t at = 0; options[at] != NULL; ++at) all[count++] = options[at];
  return plait_job_run(job, all, count, NULL, NULL, NULL, NULL);
}
static const char* const none[] = {NULL};

/* Makes a pass of a plan over `sharded` in parts: input and output are texts of options, of the
 * same store. */
static void pass_in_parts(const char* input, const char* output, const char* plan,
                          const char* const* pass, plait_part_options* options) {
  CHECK_OK(run("plan", input, plan, pass));
  CHECK_ERROR(run("join", output, plan, none), PLAIT_ERROR_BAD_STATE, "0-3");
  for (uint32_t part = 0; part < 4; ++part)
    CHECK_OK(plait_parts_make(plan + strlen("plan="), part, options));
  CHECK_OK(run("join", output, plan, none));
}

static void check_passes(const char* sharded, const char* whole, const char* base) {
  char plan[4200], input[4200], output[4200], other[4200];
  const char* const path = plan + strlen("plan=");
  snprintf(plan, sizeof(plan), "plan=%s.smooth", base);
  snprintf(input, sizeof(input), "input=%s", sharded);
  snprintf(output, sizeof(output), "output=%s", sharded);
  snprintf(other, sizeof(other), "input=%s", whole);
  const char* const smooth[] = {"pass=smooth", "factor=0", NULL};
  CHECK_ERROR(run("plan", NULL, plan, smooth), PLAIT_ERROR_INVALID_ARGUMENT, "input");
  CHECK_ERROR(run("plan", other, plan, none), PLAIT_ERROR_INVALID_ARGUMENT, "levels");
  CHECK_ERROR(run("plan", other, plan, smooth), PLAIT_ERROR_NOT_SUPPORTED, "in one piece");
  char before[PLAIT_DIGEST_BYTES] = "", found[PLAIT_DIGEST_BYTES] = "";
  digest_of(sharded, before);
  pass_in_parts(input, output, plan, smooth, NULL);
  digest_of(sharded, found);
  CHECK(strcmp(found, before) == 0); /* by a factor of 0 nothing moves */

  const char* const fold[] = {"pass=fold", "result=folded,float32,1", "parameters=2 1", NULL};
  snprintf(plan, sizeof(plan), "plan=%s.fold", base);
  int calls = 0;
  plait_part_options options = PLAIT_PART_OPTIONS_INIT;
  options.kernel = make_fold;
  options.kernel_user = &calls;
  pass_in_parts(input, output, plan, fold, &options);
  CHECK(calls == 4);
  options.again = 1;
  CHECK_ERROR(plait_parts_make(path, 0, &options), PLAIT_ERROR_BAD_STATE, "version");
  snprintf(plan, sizeof(plan), "plan=%s.again", base);
  CHECK_OK(run("plan", input, plan, fold));
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

  char input[4200], output[4200], planned[4200];
  snprintf(input, sizeof(input), "input=%s", mesh);
  snprintf(output, sizeof(output), "output=%s", arguments[1]);
  snprintf(planned, sizeof(planned), "plan=%s", plan);
  /* A tetrahedron has six edges. */
  const char* parts[] = {"levels=3", "normals", "parts=7", NULL};
  CHECK_ERROR(run("plan", input, planned, parts), PLAIT_ERROR_INVALID_ARGUMENT, "7");
  parts[2] = "parts=4";
  CHECK_OK(run("plan", input, planned, parts));
  CHECK_ERROR(run("part", "part=4", planned, none), PLAIT_ERROR_INVALID_ARGUMENT, "0 to 3");
  const char* const again[] = {"again", NULL};
  const char* const verify[] = {"verify", NULL};
  CHECK_OK(run("part", "part=1", planned, none));
  CHECK_OK(run("part", "part=1", planned, again));
  CHECK_ERROR(run("join", output, planned, none), PLAIT_ERROR_BAD_STATE, "0,2-3");
  for (uint32_t part = 0; part < 4; ++part) CHECK_OK(plait_parts_make(plan, part, NULL));
  CHECK_OK(run("join", output, planned, verify));

  snprintf(output, sizeof(output), "output=%s", whole);
  const char* const one[] = {input, output, "levels=3", "normals"};
  CHECK_OK(plait_job_run("subdivide", one, 4, NULL, NULL, NULL, NULL));
  char found[PLAIT_DIGEST_BYTES] = "", expected[PLAIT_DIGEST_BYTES] = "";
  digest_of(arguments[1], found);
  digest_of(whole, expected);
  CHECK(strcmp(found, expected) == 0);
  check_passes(arguments[1], whole, plan);
  return failures();
}
