// job.h: how a job describes itself: a table with a row for each option, and a function that runs.
//
//   Job convert_job() {
//     JobTable<ConvertArguments> table("convert", "Copy a store ...");
//     table.path("input", &ConvertArguments::from, "The store to copy").at(0).required();
//     ...
//     return table.run([](ConvertArguments& arguments, const JobCall& call) -> JobReport {...});
//   }
//
// `Arguments` is what the run gets: the job's request, with members for what a text alone does not
// decide. A new Arguments has the defaults, so that the table repeats none.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/text.h"
#include "option_text.h"
#include "plait/attribute.h"
#include "plait/existing.h"
#include "plait/job.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

using JobReport = nlohmann::ordered_json;

/// What a run gets beside its arguments.
struct JobCall {
  const BackendRegistry& backends;       ///< of new stores
  const BackendRegistry& open_backends;  ///< of existing stores
  const JobWatch& watch;
  const ParallelFor& parallel_for;
  const JobOptions& options;  ///< as they were given
};

struct Job {
  using Setter = std::function<void(void* arguments, const std::string& text)>;
  JobDescription about;
  std::vector<Setter> setters;  ///< one for each option
  std::function<std::shared_ptr<void>()> make;
  std::function<JobReport(void* arguments, const JobCall& call)> run;
};

template <class Value>
struct is_optional : std::false_type {};
template <class Value>
struct is_optional<std::optional<Value>> : std::true_type {};

template <class Arguments>
class JobTable {
 public:
  JobTable(std::string name, std::string summary) {
    job_.about.name = std::move(name);
    job_.about.summary = std::move(summary);
  }

  // Rows. `access` is a pointer to a member of Arguments, or a function that returns a reference to
  // one; the member's value in a new Arguments is the default.

  template <class Access>
  JobTable& path(const char* name, Access access, std::string help) {
    return add(
        {.name = name, .kind = OptionKind::kPath, .help = std::move(help), .value_name = "PATH"},
        [access](Arguments& arguments, const std::string& text) {
          std::invoke(access, arguments) = std::filesystem::path(text);
        });
  }
  template <class Access>
  JobTable& output(const char* name, Access access, std::string help) {
    path(name, access, std::move(help));
    row().output = true;
    return *this;
  }
  template <class Access>
  JobTable& text(const char* name, Access access, std::string help) {
    add({.name = name, .kind = OptionKind::kText, .help = std::move(help), .value_name = "TEXT"},
        [access](Arguments& arguments, const std::string& text) {
          std::invoke(access, arguments) = text;
        });
    using Member = std::decay_t<std::invoke_result_t<Access, Arguments&>>;
    if constexpr (std::is_same_v<Member, std::string>)
      if (const std::string& value = std::invoke(access, defaults_); !value.empty())
        row().default_text = value;
    return *this;
  }
  template <class Access>
  JobTable& texts(const char* name, Access access, std::string help) {
    return add(
        {.name = name, .kind = OptionKind::kTexts, .help = std::move(help), .value_name = "TEXT"},
        [access](Arguments& arguments, const std::string& text) {
          std::invoke(access, arguments).push_back(text);
        });
  }
  /// A member that is 0 by default has no default text: 0 stands for a value that the job chooses.
  template <class Access>
  JobTable& bytes(const char* name, Access access, std::string help) {
    add({.name = name, .kind = OptionKind::kBytes, .help = std::move(help), .value_name = "SIZE"},
        [access](Arguments& arguments, const std::string& text) {
          std::invoke(access, arguments) = parse_size(text);
        });
    using Member = std::decay_t<std::invoke_result_t<Access, Arguments&>>;
    if constexpr (std::is_integral_v<Member>)
      if (const std::uint64_t value = std::invoke(access, defaults_); value != 0)
        row().default_text = size_text(value);
    return *this;
  }
  template <class Access>
  JobTable& count(const char* name, Access access, std::uint64_t first, std::uint64_t last,
                  std::string help) {
    using Member = std::decay_t<std::invoke_result_t<Access, Arguments&>>;
    add({.name = name,
         .kind = OptionKind::kCount,
         .help = std::move(help),
         .value_name = "N",
         .first = first,
         .last = last},
        [access, first, last](Arguments& arguments, const std::string& text) {
          const std::uint64_t value = parse_whole_number(text, first, last);
          if constexpr (is_optional<Member>::value)
            std::invoke(access, arguments) = static_cast<typename Member::value_type>(value);
          else
            std::invoke(access, arguments) = static_cast<Member>(value);
        });
    if constexpr (!is_optional<Member>::value)
      if (const Member value = std::invoke(access, defaults_);
          static_cast<std::uint64_t>(value) >= first && static_cast<std::uint64_t>(value) <= last)
        row().default_text = std::to_string(value);
    return *this;
  }
  template <class Access>
  JobTable& number(const char* name, Access access, double low, double high, std::string help) {
    using Member = std::decay_t<std::invoke_result_t<Access, Arguments&>>;
    add({.name = name,
         .kind = OptionKind::kNumber,
         .help = std::move(help),
         .value_name = "NUMBER",
         .low = low,
         .high = high},
        [access, low, high](Arguments& arguments, const std::string& text) {
          std::invoke(access, arguments) = parse_number(text, low, high);
        });
    if constexpr (!is_optional<Member>::value)
      row().default_text = fmt::format("{}", std::invoke(access, defaults_));
    return *this;
  }
  template <class Access>
  JobTable& flag(const char* name, Access access, std::string help) {
    return add(
        {.name = name, .kind = OptionKind::kFlag, .help = std::move(help), .default_text = "false"},
        [access](Arguments& arguments, const std::string& text) {
          std::invoke(access, arguments) = text == "true";
        });
  }
  /// `set` gets one of the choices.
  JobTable& choice(const char* name, std::vector<std::string> choices,
                   std::function<void(Arguments&, const std::string&)> set, std::string help) {
    std::string shown;
    for (const std::string& each : choices) shown += (shown.empty() ? "" : "|") + each;
    return add({.name = name,
                .kind = OptionKind::kChoice,
                .help = std::move(help),
                .value_name = std::move(shown),
                .choices = std::move(choices)},
               std::move(set));
  }
  /// `set` gets any text.
  JobTable& named(const char* name, std::function<void(Arguments&, const std::string&)> set,
                  std::string help) {
    return add(
        {.name = name, .kind = OptionKind::kText, .help = std::move(help), .value_name = "TEXT"},
        std::move(set));
  }

  // Rows that several jobs have.

  /// Arguments get the number of processors, unless the option says another one.
  template <class Access>
  JobTable& threads(Access access, std::string help) {
    prepare_.push_back([access, name = job_.about.name](Arguments& arguments) {
      std::invoke(access, arguments) = thread_count(0, name);
    });
    add({.name = "threads",
         .kind = OptionKind::kCount,
         .help = help + "; 0: all processors",
         .value_name = "N",
         .default_text = "0",
         .first = 0,
         .last = 1024},
        [access, name = job_.about.name](Arguments& arguments, const std::string& text) {
          std::invoke(access, arguments) =
              thread_count(static_cast<int>(parse_whole_number(text, 0, 1024)), name);
        });
    return *this;
  }
  template <class Access>
  JobTable& force(
      Access access,
      std::string help = "Replace OUTPUT if it is a store, when the new store is complete",
      std::string means = "replaces a store") {
    return add({.name = "force",
                .kind = OptionKind::kFlag,
                .help = std::move(help),
                .default_text = "false"},
               [access](Arguments& arguments, const std::string& text) {
                 std::invoke(access, arguments) =
                     text == "true" ? Existing::kReplace : Existing::kRefuse;
               })
        .remedy(std::move(means));
  }
  template <class Access>
  JobTable& precision(Access access, std::string help) {
    return choice(
               "precision", {"auto", "float32", "float64"},
               [access](Arguments& arguments, const std::string& name) {
                 auto& precision = std::invoke(access, arguments);
                 if (name == "auto")
                   precision.reset();
                 else
                   precision =
                       name == "float64" ? ComponentType::kFloat64 : ComponentType::kFloat32;
               },
               std::move(help))
        .by_default("auto");
  }
  template <class Access>
  JobTable& weld(Access access) {
    constexpr double kFarthest = std::numeric_limits<double>::max();
    return add({.name = "weld",
                .kind = OptionKind::kNumber,
                .help = "Vertices at most this far from each other become one; without a number "
                        "those of equal positions",
                .value_name = "[TOLERANCE]",
                .choices = {"true"},
                .high = kFarthest},
               [access](Arguments& arguments, const std::string& text) {
                 std::invoke(access, arguments) =
                     text == "true" ? 0 : parse_number(text, 0, kFarthest);
               });
  }
  template <class Access>
  JobTable& compress(Access access) {
    return texts("compress", access,
                 "How blocks are compressed: a preset or a pipeline (see below), for all "
                 "attributes and levels or as ATTRIBUTE=..., @LEVELS=... or "
                 "ATTRIBUTE@LEVELS=...; may be repeated")
        .shown_as("PRESET|[FILTER+FILTER,]CODEC[:LEVEL]");
  }
  template <class Access>
  JobTable& max_error(Access access) {
    return texts("max-error", access,
                 "Round vertices, by at most this much (see below): of \"position\", or as "
                 "ATTRIBUTE=...; may be repeated")
        .shown_as("BOUND[rel][,euclidean]");
  }

  // Changes of the last row.

  JobTable& required() {
    row().required = true;
    row().default_text.reset();
    return *this;
  }
  JobTable& at(int position) {
    row().position = position;
    return *this;
  }
  JobTable& by_default(std::string text) {
    row().default_text = std::move(text);
    return *this;
  }
  JobTable& shown_as(std::string value_name) {
    row().value_name = std::move(value_name);
    return *this;
  }
  JobTable& remedy(std::string text) {
    row().remedy = std::move(text);
    return *this;
  }
  /// A count that also takes a word, which stands for no value.
  JobTable& or_word(const std::string& word) {
    row().choices = {word};
    row().value_name += "|" + word;
    row().default_text = word;
    job_.setters.back() = [set = job_.setters.back(), word](void* to, const std::string& text) {
      if (text != word) set(to, text);
    };
    return *this;
  }

  /// The job. `run` may change its arguments.
  Job run(std::function<JobReport(Arguments&, const JobCall&)> run) {
    job_.make = [prepare = prepare_]() -> std::shared_ptr<void> {
      auto arguments = std::make_shared<Arguments>();
      for (const auto& each : prepare) each(*arguments);
      return arguments;
    };
    job_.run = [run = std::move(run)](void* arguments, const JobCall& call) {
      return run(*static_cast<Arguments*>(arguments), call);
    };
    return std::move(job_);
  }

 private:
  JobOption& row() { return job_.about.options.back(); }
  JobTable& add(JobOption option, std::function<void(Arguments&, const std::string&)> set) {
    job_.about.options.push_back(std::move(option));
    job_.setters.push_back([set = std::move(set)](void* to, const std::string& text) {
      set(*static_cast<Arguments*>(to), text);
    });
    return *this;
  }

  Arguments defaults_ = Arguments();
  Job job_;
  std::vector<std::function<void(Arguments&)>> prepare_;
};

/// All jobs, in the order of the program's --help.
const std::vector<Job>& all_jobs();

// One for each table file.
Job check_job();
Job compare_job();
Job convert_job();
Job export_job();
Job generate_job();
Job import_job();
Job layout_job();
Job pass_job();
Job prune_job();
Job publish_job();
Job remesh_job();
Job render_job();
Job subdivide_job();

PLAIT_END_NAMESPACE
