/* tests/c/check.h: checks for tests in C. A failed check is printed and counted; main() returns
 * failures() at the end. */
#ifndef PLAIT_TESTS_C_CHECK_H
#define PLAIT_TESTS_C_CHECK_H

#include <stdio.h>
#include <string.h>

#include "plait.h"

static int failed_checks = 0;

static inline int failures(void) {
  if (failed_checks > 0) printf("%d checks failed\n", failed_checks);
  return failed_checks > 0 ? 1 : 0;
}

static inline void check_at(int holds, const char* text, int line) {
  if (holds) return;
  printf("line %d: %s; last message: %s\n", line, text, plait_error_message());
  ++failed_checks;
}
#define CHECK(condition) check_at((condition) ? 1 : 0, #condition, __LINE__)
#define CHECK_OK(call) check_at((call) == PLAIT_OK, #call, __LINE__)

/* The call has failed with this code, and its message has these words. */
static inline void check_error_at(plait_status found, plait_status expected, const char* words,
                                  const char* text, int line) {
  if (found == expected && strstr(plait_error_message(), words) != NULL) return;
  printf("line %d: %s: expected %s with \"%s\", found %s with \"%s\"\n", line, text,
         plait_status_name(expected), words, plait_status_name(found), plait_error_message());
  ++failed_checks;
}
#define CHECK_ERROR(call, code, words) check_error_at((call), (code), (words), #call, __LINE__)

/* A regular tetrahedron around the origin. */
static const double tetrahedron_positions[12] = {1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1};
static const uint32_t tetrahedron_triangles[12] = {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2};

/* A store in memory, with attribute "position" at level 0. */
static inline plait_store* tetrahedron_store(void) {
  plait_store_options options = PLAIT_STORE_OPTIONS_INIT;
  plait_store* store = NULL;
  options.backend = "memory";
  options.block_bytes = 4096;
  CHECK_OK(
      plait_store_create("", tetrahedron_positions, 4, tetrahedron_triangles, 4, &options, &store));
  return store;
}

#endif
