// Pages as HTML.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "instrument/page.h"
#include "instrument/page_assets.h"
#include "instrument/svg_plots.h"

namespace plait::instrument {
namespace {

using nlohmann::ordered_json;

/// The same text with replacement characters for what is not UTF-8, and without control characters.
std::string valid_text(std::string_view text) {
  const ordered_json quoted(std::string{text});
  std::string valid =
      ordered_json::parse(quoted.dump(-1, ' ', false, ordered_json::error_handler_t::replace));
  for (char& character : valid)
    if (static_cast<unsigned char>(character) < 0x20 && character != '\n') character = ' ';
  return valid;
}

std::string_view class_of(Tone tone) {
  constexpr std::string_view kClasses[] = {"plain", "good", "doubt", "failed"};
  return kClasses[static_cast<std::size_t>(tone)];
}

/// A cell of the tables under the plots, with the exact number.
TableCell number_cell(double value) {
  if (!std::isfinite(value)) return TableCell("–", kMissing);
  return TableCell(fmt::format("{:.6g}", value), value);
}

/// With replacements for some characters.
template <class Replace>
std::string replaced(const std::string& text, Replace replacement_of) {
  std::string result;
  for (const char character : text)
    if (const char* const replacement = replacement_of(character))
      result += replacement;
    else
      result += character;
  return result;
}

}  // namespace

std::string escape_html(std::string_view text) {
  return replaced(valid_text(text), [](char character) -> const char* {
    switch (character) {
      case '&':
        return "&amp;";
      case '<':
        return "&lt;";
      case '>':
        return "&gt;";
      case '"':
        return "&quot;";
      case '\'':
        return "&#39;";
      default:
        return nullptr;
    }
  });
}

std::string script_json(const ordered_json& data) {
  // With '<' as \u003c there is neither "</script" nor "<!--"; both only occur inside strings.
  return replaced(data.dump(-1, ' ', false, ordered_json::error_handler_t::replace),
                  [](char character) {
                    return character == '<'   ? "\\u003c"
                           : character == '>' ? "\\u003e"
                           : character == '&' ? "\\u0026"
                                              : nullptr;
                  });
}

/// Writes the parts of a page, one after another.
class HtmlWriter {
 public:
  void operator()(const Page::Verdict& part) {
    failed = failed || part.tone == Tone::kFailed;
    body += fmt::format("<p class=\"verdict {}\">{}</p>\n", class_of(part.tone),
                        escape_html(part.text));
  }
  void operator()(const Page::Section& part) {
    body += fmt::format("<h2>{}</h2>\n", escape_html(part.text));
  }
  void operator()(const Page::Paragraph& part) {
    body += fmt::format("<p>{}</p>\n", escape_html(part.text));
  }
  void operator()(const Page::List& part) {
    body += fmt::format("<ul class=\"{}\">\n", class_of(part.tone));
    for (const std::string& item : part.items)
      body += fmt::format("<li>{}</li>\n", escape_html(item));
    body += "</ul>\n";
  }
  void operator()(const Page::Command& part) {
    if (!part.text.empty()) body += fmt::format("<pre>{}</pre>\n", escape_html(part.text));
  }
  void operator()(const Page::Picture&) {}
  void operator()(const Page::Data& part) {
    data += fmt::format("<script type=\"application/json\" id=\"{}\">{}</script>\n",
                        escape_html(part.id), script_json(part.data));
  }
  void operator()(const Table& table) {
    body += "<figure>\n";
    if (!table.caption.title.empty()) begin_figure(table.caption);
    write_rows(table);
    (*this)(Page::Command{table.caption.command});
    body += "</figure>\n";
  }
  void operator()(const IntervalPlot& plot) {
    Table numbers{
        plot.caption,
        {{"group", false}, {"name", false}, {plot.x.label}, {"low"}, {"high"}, {"note", false}}};
    for (const IntervalPlot::Point& point : plot.points)
      numbers.rows.push_back({{point.group, point.name, number_cell(point.value),
                               number_cell(point.low), number_cell(point.high), point.note}});
    if (!numbers.rows.empty() && numbers.rows.size() < kLeastPoints) return (*this)(numbers);
    add_plot(plot, numbers);
  }
  void operator()(const ScatterPlot& plot) {
    Table numbers{plot.caption,
                  {{"series", false}, {"name", false}, {plot.x.label}, {plot.y.label}}};
    for (const ScatterPlot::Point& point : plot.points)
      numbers.rows.push_back(
          {{point.series, point.name, number_cell(point.x), number_cell(point.y)},
           point.front ? Tone::kGood : Tone::kPlain});
    add_plot(plot, numbers);
  }

  bool failed = false;
  std::string body, data;

 private:
  void begin_figure(const Caption& caption) {
    body += fmt::format("<figcaption><strong>{}</strong>", escape_html(caption.title));
    if (!caption.how_to_read.empty())
      body += fmt::format("<p>{}</p>", escape_html(caption.how_to_read));
    body += "</figcaption>\n";
  }

  void write_rows(const Table& table) {
    body += "<div class=\"scroll\" tabindex=\"0\"><table class=\"sortable\">\n<thead><tr>";
    for (const Table::Column& column : table.columns)
      body += fmt::format("<th scope=\"col\"{}>{}</th>", column.number ? " class=\"number\"" : "",
                          escape_html(column.name));
    body += "</tr></thead>\n<tbody>\n";
    for (const Table::Row& row : table.rows) {
      body +=
          row.tone == Tone::kPlain ? "<tr>" : fmt::format("<tr class=\"{}\">", class_of(row.tone));
      for (std::size_t at = 0; at < row.cells.size() && at < table.columns.size(); ++at) {
        const TableCell& cell = row.cells[at];
        body += table.columns[at].number ? "<td class=\"number\"" : "<td";
        // The shortest text that reads back as the same number.
        if (cell.value && std::isfinite(*cell.value))
          body += fmt::format(" data-value=\"{}\"", *cell.value);
        body += fmt::format(">{}</td>", escape_html(cell.text));
      }
      body += "</tr>\n";
    }
    body += "</tbody>\n</table></div>\n";
  }

  template <class Plot>
  void add_plot(const Plot& plot, const Table& numbers) {
    if (numbers.rows.empty())
      return (*this)(Page::Paragraph{plot.caption.title + ": no run measured this."});
    body += "<figure>\n";
    begin_figure(plot.caption);
    body += fmt::format("<div class=\"plot\">{}</div>\n<details><summary>The numbers</summary>\n",
                        svg_plot(plot, series_));
    write_rows(numbers);
    body += "</details>\n";
    (*this)(Page::Command{plot.caption.command});
    body += "</figure>\n";
  }

  SeriesNames series_;
};

Page::Page(std::string title, std::string subtitle)
    : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

std::string Page::html() const {
  HtmlWriter writer;
  for (const Part& part : parts_) std::visit(writer, part);
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
      "'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action "
      "'none'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n<title>{}{}</title>\n<style>\n{}</style>\n</head>\n"
      "<body{}>\n<h1>{}</h1>\n<p class=\"subtitle\">{}</p>\n{}{}<script>\"use "
      "strict\";{}</script>\n</body>\n</html>\n",
      writer.failed ? "FAILED: " : "", escape_html(title_), kPageStyle,
      writer.failed ? " class=\"failed\"" : "", escape_html(title_), escape_html(subtitle_),
      writer.body, writer.data, kPageScript);
}

}  // namespace plait::instrument
