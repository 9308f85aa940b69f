// Prints each option of each job, as C++ has it: "JOB OPTION KIND DEFAULT", with "-" for an option
// without a default. tests/python/job_doors_test.py compares it with the other ways to a job.
#include <iostream>

#include "plait/job.h"

int main() {
  for (const plait::JobDescription& job : plait::known_jobs())
    for (const plait::JobOption& option : job.options)
      std::cout << job.name << ' ' << option.name << ' ' << to_string(option.kind) << ' '
                << option.default_text.value_or("-") << '\n';
}
