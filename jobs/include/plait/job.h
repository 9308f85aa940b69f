// plait/job.h: whole works by their names: what the commands of the program do, with the same
// options. The program, the C interface and the Python package have their options from here.
//
//   const std::string report = run_job("convert", {{"input", "a.plait"}, {"output", "b.plait"},
//                                                  {"compress", "small"}});
//
// Pinned by tests/jobs/job_test.cpp and tests/python/job_doors_test.py.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/error.h"
#include "plait/progress.h"

PLAIT_BEGIN_NAMESPACE

class BackendRegistry;

/// What the text of an option says.
enum class OptionKind : std::uint8_t {
  kPath,
  kText,
  kTexts,   ///< as kText, and the option may be given several times
  kBytes,   ///< 65536, 64KiB, 1.5GiB
  kCount,   ///< a whole number, or one of `choices`
  kNumber,  ///< a number with a fraction, or one of `choices`
  kChoice,  ///< one of `choices`
  kFlag,    ///< true or false
};
/// "path", "text", "texts", "bytes", "count", "number", "choice", "flag".
std::string_view to_string(OptionKind kind) noexcept;

/// An option of a job.
struct JobOption {
  std::string name = {};  ///< "max-error": as the program writes it after --
  OptionKind kind = OptionKind::kText;
  std::string help = {};                         ///< one line
  std::string value_name = {};                   ///< what --help writes for the value: "SIZE"
  std::optional<std::string> default_text = {};  ///< a text that means the same as no text
  std::vector<std::string> choices = {};  ///< of kChoice; of numbers: words that they take too
  std::uint64_t first = 0;                ///< of kCount
  std::uint64_t last = 0;                 ///< of kCount
  double low = 0, high = 0;               ///< of kNumber
  bool required = false;
  bool output = false;      ///< of kPath: what the job makes
  int position = -1;        ///< 0, 1, ...: the program takes it without its name, in this order
  std::string remedy = {};  ///< what the option does about a refusal that names it: "starts anyway"
};

/// A job and its options.
struct JobDescription {
  std::string name;     ///< "convert"
  std::string summary;  ///< one line
  std::vector<JobOption> options;
};

/// All jobs.
const std::vector<JobDescription>& known_jobs();
/// Errors: kInvalidArgument for a name that no job has; the message lists the jobs.
const JobDescription& find_job(std::string_view name);
/// The job, or with an empty name all jobs, as JSON: {"name", "summary", "options": [{"name",
/// "kind", "help", "default", "choices", "required", "position"}]}.
std::string job_description_json(std::string_view name = {});
/// Throws kInvalidArgument unless the option takes this text. Names of backends, schemes and
/// pipelines are checked only by run_job().
void check_option(const JobOption& option, const std::string& text);

/// Names and texts of options: {{"levels", "5"}, {"normals", "true"}}.
using JobOptions = std::vector<std::pair<std::string, std::string>>;

/// Whom a job tells how far it is. The thread that runs the job calls all of them (`progress`: see
/// plait/progress.h).
struct JobWatch {
  std::function<void(std::string_view)> step = {};  ///< the name of a step, when it begins
  ProgressCallback progress = {};                   ///< counts of the step
  std::function<void(const std::string&)> warn = {};
  /// Called before the job changes anything on the disk. May throw: then nothing has changed.
  std::function<void()> before_files = {};
};

/// What a program may bring beside the options.
struct JobContext {
  const BackendRegistry* backends = nullptr;       ///< of new stores; nullptr: default_backends()
  const BackendRegistry* open_backends = nullptr;  ///< of existing stores; nullptr: `backends`
  std::string option_prefix = {};                  ///< "--": so errors name options
  ParallelFor parallel_for = {};                   ///< as in StoreOptions
};

/// An error that an option can avoid, or that has more to tell than a line.
class JobError : public Error {
 public:
  JobError(ErrorCode code, const std::string& message, std::string option, std::string report = {})
      : Error(code, message), option_(std::move(option)), report_(std::move(report)) {}
  JobError(const Error& error, const std::string& message, std::string option,
           std::string report = {})
      : Error(error, message), option_(std::move(option)), report_(std::move(report)) {}
  /// The option that must change, or that helps; may be empty.
  const std::string& option() const noexcept { return option_; }
  /// A JSON object, such as the parts that are missing; may be empty.
  const std::string& report() const noexcept { return report_; }

 private:
  std::string option_, report_;
};

/// Runs a job. Returns what it did as a JSON object: that of the program's --json. After an error
/// nothing half-made is left. Errors: kInvalidArgument for an option that the job does not have, a
/// text that the option does not take, and a required option that is missing; those of the job, as
/// JobError where an option can avoid them. Threads: any; each call has its own job.
std::string run_job(std::string_view job, const JobOptions& options, const JobWatch& watch = {},
                    const JobContext& context = {});

PLAIT_END_NAMESPACE
