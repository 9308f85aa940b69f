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

std::string absolute_text(const std::filesystem::path& path) {
  return std::filesystem::absolute(path).lexically_normal().native();
}

void write_script(const std::filesystem::path& script, const std::string& text) {
  UnpublishedFile file(script, Existing::kRefuse);
  build_output(file, [&] { file.file().write_at(0, std::as_bytes(std::span(text))); });
  file.publish();
}

}  // namespace

void write_sbatch_script(const std::filesystem::path& script, const std::filesystem::path& path,
                         const PartsPlan& plan, std::uint32_t longest) {
  // The estimate is for an ordinary disk; other parts may wait for the same one.
  constexpr double kTimesTheEstimate = 4;
  constexpr int kFewestMinutes = 10;
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
  text += fmt::format("exec plait part {} \"$SLURM_ARRAY_TASK_ID\" \"$@\"\n",
                      shell_quoted(absolute_text(path)));
  write_script(script, text);
}

void write_chain_script(const std::filesystem::path& chain, const std::filesystem::path& array,
                        const std::filesystem::path& path, const PartsPlan& plan,
                        std::uint32_t longest) {
  constexpr int kMinutes = 60;
  const auto parts = static_cast<std::uint32_t>(plan.parts.size());
  const std::string name = chain.filename().native();
  std::string text = fmt::format(
      "#!/bin/sh\n"
      "# Submits the parts of the plan, and a job that joins them when they have ended:\n"
      "#   sh {0} STORE [COMMAND]\n"
      "# Lost parts are submitted once more. COMMAND is one word for the shell, which runs it "
      "after "
      "a join that ended well:\n"
      "#   sh {0} statue.plait 'plait plan --pass smooth statue.plait smooth.plan --sbatch "
      "smooth.sh "
      "--chain next.sh && sh next.sh statue.plait'\n"
      "#SBATCH --ntasks=1\n"
      "#SBATCH --time={1}\n"
      "#SBATCH --output=%x-%j.out\n"
      "plan={2}\narray={3}\nchain={4}\n",
      name, kMinutes, shell_quoted(absolute_text(path)), shell_quoted(absolute_text(array)),
      shell_quoted(absolute_text(chain)));
  text +=
      "# The number of the job, of what sbatch --parsable prints.\n"
      "submit() {\n"
      "  job=$(sbatch --parsable \"$@\") || exit\n"
      "  job=${job%%;*}\n"
      "}\n"
      "join_after() {  # JOBS STORE COMMAND TRIES\n"
      "  submit --dependency=afterany\"$1\" \"$chain\" --join \"$2\" \"$3\" \"$4\"\n"
      "  echo \"job $job joins the parts into $2\"\n"
      "}\n"
      "if [ \"${1-}\" != --join ]; then\n"
      "  if [ $# -lt 1 ] || [ $# -gt 2 ]; then\n"
      "    echo \"expected STORE [COMMAND], found $# arguments\" >&2\n"
      "    exit 2\n"
      "  fi\n"
      "  jobs=\n";
  for (std::uint32_t first = 0; first < parts; first += longest)
    text += fmt::format("  submit --array=0-{} \"$array\"{}\n  jobs=$jobs:$job\n",
                        std::min(longest, parts - first) - 1,
                        first == 0 ? "" : fmt::format(" --offset {}", first));
  text += fmt::format(
      "  join_after \"$jobs\" \"$1\" \"${{2-}}\" 1\n"
      "  exit\n"
      "fi\n"
      "store=$2 command=$3 tries=$4 status=0\n"
      "plait join \"$plan\" \"$store\" --missing-to \"$store.lost\" || status=$?\n"
      "if [ $status -eq 4 ] && [ \"$tries\" -gt 0 ]; then\n"
      "  lost=$(wc -l <\"$store.lost\")\n"
      "  [ \"$lost\" -le {0} ] || lost={0}\n"
      "  case $store in /*) list=$store.lost ;; *) list=$PWD/$store.lost ;; esac\n"
      "  submit --array=0-$((lost - 1)) \"$array\" --list \"$list\"\n"
      "  join_after \":$job\" \"$store\" \"$command\" $((tries - 1))\n"
      "  exit\n"
      "fi\n"
      "[ $status -eq 0 ] || exit $status\n"
      "rm -f \"$store.lost\"\n"
      "[ -z \"$command\" ] || exec sh -c \"$command\"\n",
      longest);
  write_script(chain, text);
}

PLAIT_END_NAMESPACE
