#include "parts/parts_script.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>

#include "io/unpublished.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// For the shell: in single quotes.
std::string shell_quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

/// An option of plait part, unless the script was given one.
std::string unless_given(const std::string& option, const std::string& value) {
  return fmt::format(
      "case \" $*\" in *\" {0} \"* | *\" {0}=\"*) ;; *) set -- \"$@\" {0} {1} ;; esac\n", option,
      value);
}

}  // namespace

void write_sbatch_script(const std::filesystem::path& script, const std::filesystem::path& path,
                         const PartsPlan& plan, std::uint32_t longest) {
  // The estimate is for an ordinary disk; other parts may wait for the same one.
  constexpr double kTimesTheEstimate = 4;
  constexpr int kFewestMinutes = 10;
  const std::string absolute = std::filesystem::absolute(path).lexically_normal().native();
  const auto parts = static_cast<std::uint32_t>(plan.parts.size());
  const double worst = std::ranges::max(plan.parts, {}, &PlannedPart::seconds).seconds;
  const int minutes =
      kFewestMinutes + static_cast<int>(std::min(kTimesTheEstimate * worst / 60, 1e6));
  std::string text = "#!/bin/sh\n# Makes the parts of the plan, one in each task of the array:\n";
  for (std::uint32_t first = 0; first < parts; first += longest) {
    const std::uint32_t last = std::min(longest, parts - first) - 1;
    text += first == 0
                ? fmt::format("#   sbatch --array=0-{} {}\n", last, script.filename().native())
                : fmt::format("#   sbatch --array=0-{} {} --offset {}\n", last,
                              script.filename().native(), first);
  }
  text += fmt::format(
      "# Then plait join PLAN STORE --missing-to lost writes the parts that are missing, one a "
      "line:\n"
      "#   sbatch --array=0-$(($(wc -l <lost) - 1)) {} --list \"$PWD/lost\"\n"
      "#SBATCH --array=0-{}\n"
      "#SBATCH --ntasks=1\n"
      "#SBATCH --cpus-per-task=1\n"
      "#SBATCH --time={}\n",
      script.filename().native(), std::min(longest, parts) - 1, minutes);
  if (plan.memory) text += fmt::format("#SBATCH --mem={}M\n", plan.memory->total_bytes >> 20);
  text += "#SBATCH --output=%x-%A_%a.out\n#SBATCH --requeue\n";
  if (plan.memory) text += unless_given("--memory", std::to_string(plan.memory->budget_bytes));
  text += unless_given("--threads", "\"${SLURM_CPUS_PER_TASK:-1}\"");
  text +=
      fmt::format("exec plait part {} \"$SLURM_ARRAY_TASK_ID\" \"$@\"\n", shell_quoted(absolute));
  UnpublishedFile file(script, Existing::kRefuse);
  build_output(file, [&] { file.file().write_at(0, std::as_bytes(std::span(text))); });
  file.publish();
}

PLAIT_END_NAMESPACE
