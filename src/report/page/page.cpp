#include "report/page/page.hpp"

#include <algorithm>

#include "core/text.hpp"

namespace qerr::page {

std::string json_script(std::string json, const std::string& attributes) {
  for (std::size_t i = 0; (i = json.find_first_of("<>&", i)) != std::string::npos;)
    json.replace(i, 1, json[i] == '<' ? "\\u003c" : json[i] == '>' ? "\\u003e" : "\\u0026");
  return "<script type=\"application/json\"" + attributes + '>' + json + "</script>";
}

std::string bar_cell(const std::string& text, double part, double value, int colour) {
  return "<td class=\"use " + (part > 1 ? "over" : 's' + std::to_string(colour)) + '"' +
         data_attribute("data-value", value) +
         " style=\"--p:" + significant(100 * std::clamp(part, 0.0, 1.0), 4) + "%\">" + escaped_markup(text) +
         "</td>";
}

std::string cell(const std::string& text) { return "<td>" + name_markup(text) + "</td>"; }

std::string table_of(std::string_view style, const std::vector<std::string>& header,
                     const std::vector<std::string>& rows) {
  std::string out = "<div class=\"wide\"><table class=\"" + std::string(style) + "\"><thead><tr>";
  for (const std::string& head : header)
    out += "<th scope=\"col\">" + escaped_markup(isolated_runs(head)) + "</th>";
  out += "</tr></thead><tbody>\n";
  for (const std::string& row : rows) out += "<tr>" + row + "</tr>\n";
  return out + "</tbody></table></div>\n";
}

std::string table(const std::vector<std::string>& header, const TableRows& rows) {
  std::vector<std::string> marked;
  for (const auto& row : rows) {
    marked.emplace_back();
    for (const std::string& text : row) marked.back() += cell(isolated_runs(text));
  }
  return table_of("plain", header, marked);
}

std::string table(TableRows rows, const std::string& corner) {
  std::vector<std::string> header = std::move(rows.front());
  if (header.front().empty()) header.front() = corner;
  rows.erase(rows.begin());
  return table(header, rows);
}

std::string title_list(const std::vector<std::pair<std::string, std::string>>& entries) {
  std::string out = "<div class=\"head\"><dl class=\"about\">";
  for (const auto& [name, text] : entries) out += "<dt>" + name + "</dt><dd>" + text + "</dd>";
  return out + "</dl>";
}

std::string choice(const std::string& label,
                   const std::vector<std::pair<std::string, std::string>>& figures) {
  std::string out = "<div class=\"choice\">";
  if (figures.size() > 1) {
    out += "<label hidden=\"hidden\">" + escaped_markup(label) + " <select>";
    for (const auto& [name, body] : figures) out += "<option>" + escaped_markup(name) + "</option>";
    out += "</select></label>";
  }
  for (const auto& [name, body] : figures) out += "<div class=\"option\">" + body + "</div>\n";
  return out + "</div>\n";
}

std::string markup(const Page& page) {
  std::string out =
      "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\"><head><meta "
      "charset=\"utf-8\"/>"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/><title>" +
      escaped_markup(page.title) + "</title><style>" + std::string(style_sheet) +
      "</style></head><body><main>\n<h1>" + name_markup(page.title) + "</h1>\n<p class=\"answer\">" +
      escaped_markup(page.answer) + "</p>\n" + page.about + "<div class=\"sections\">\n";
  for (const PageSection& s : page.sections)
    out += "<section><h2>" + escaped_markup(s.heading) + "</h2>\n" + s.body + "</section>\n";
  if (!page.warnings.empty()) {
    out += "<section><h2>Warnings and assumptions</h2><ul>\n";
    for (const std::string& w : page.warnings) out += "<li>" + escaped_markup(w) + "</li>\n";
    out += "</ul></section>\n";
  }
  out += "</div>\n";
  if (!page.spec_text.empty())
    out += "<details><summary>Spec " + name_markup(page.spec_file) + "</summary><pre>" +
           escaped_markup(page.spec_text) + "</pre></details>\n";
  if (!page.report.empty()) out += json_script(page.report, " id=\"report\"");
  return out + "</main><script>//<![CDATA[\n" + std::string(script) + "//]]></script></body></html>\n";
}

std::size_t bytes_left(const Page& page) {
  // Some texts are given without the entities and elements around them: a reserve of 25 kB.
  constexpr std::size_t most = 275000, fewest = 40000;
  std::size_t taken = page.answer.size() + page.about.size() + page.spec_text.size();
  for (const PageSection& s : page.sections) taken += s.heading.size() + s.body.size();
  for (const std::string& w : page.warnings) taken += w.size();
  return most > taken + fewest ? most - taken : fewest;
}

namespace {

/// Letters of scripts that are written from the right (Unicode's blocks of Bidi_Class R and AL).
bool from_the_right(unsigned code) {
  return (code >= 0x590 && code <= 0x8FF) || (code >= 0xFB1D && code <= 0xFDFF) ||
         (code >= 0xFE70 && code <= 0xFEFC) || (code >= 0x10800 && code <= 0x10FFF) ||
         (code >= 0x1E800 && code <= 0x1EFFF);
}

bool between_words(char c) { return c == ' ' || c == '_' || c == '-'; }

}  // namespace

std::string isolated_runs(const std::string& text) {
  std::string out;
  std::size_t run = std::string::npos;  // its first byte in `out`
  std::size_t end = 0;                  // of its last letter in `out`
  bool any = false;
  const auto close = [&] {
    if (run == std::string::npos) return;
    out.insert(end, "\u2069");
    out.insert(run, "\u2068");
    run = std::string::npos;
  };
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = std::max<std::size_t>(1, utf8_length(text, at));
    const bool right = length > 1 && from_the_right(code_point(text, at));
    if (!right && !between_words(text[at])) close();
    if (right && run == std::string::npos) run = out.size();
    out.append(text, at, length);
    if (right) end = out.size(), any = true;
    at += length;
  }
  close();
  return any ? "\u200E" + out : out;
}

std::string isolated(const std::string& name) { return "\u2068" + name + "\u2069"; }

std::string paragraph(const std::string& text) {
  return text.empty() ? "" : "<p>" + escaped_markup(isolated_runs(text)) + "</p>\n";
}

std::string list(const std::vector<std::string>& items) {
  if (items.empty()) return "";
  std::string out = "<ul>\n";
  for (const std::string& item : items) out += "<li>" + escaped_markup(isolated_runs(item)) + "</li>\n";
  return out + "</ul>\n";
}

std::string subtitle(const std::string& name) {
  return "<h3>" + escaped_markup(isolated_runs(name)) + "</h3>\n";
}

AxisRange time_axis(double last) { return {"time", "s", false, last < 1}; }

std::string side_by_side(const std::string& figures) {
  return figures.empty() ? "" : "<div class=\"figures\">" + figures + "</div>\n";
}

const std::string_view style_sheet = R"(
:root{--ink:#1a1f27;--soft:#566070;--paper:#fff;--card:#f5f7fa;--grid:#dde2e9;--c0:#0072b2;--c1:#c24f00;--c2:#007a59;--c3:#a0437c;--c4:#806600;--bad:#b3261e;--good:#0b6b45;color-scheme:light dark}
body{margin:0 auto;max-width:1280px;padding:1.2rem;color:var(--ink);background:var(--paper);font:16px/1.45 system-ui,sans-serif;overflow-wrap:anywhere}
h1{font-size:1.7rem;line-height:1.2;margin:.2rem 0 .6rem}h2{font-size:1.15rem;margin:0 0 .6rem;break-after:avoid}h3{font-size:1rem}
.answer{font-size:1.15rem;max-width:60rem;margin:.4rem 0 1rem}
.head{display:flex;flex-wrap:wrap;gap:.4rem 2rem;background:var(--card);border:1px solid var(--grid);border-radius:8px;padding:.7rem 1rem;margin-bottom:1rem;align-items:start}.head>.about{flex:1 1 24rem}.head>div{min-width:0;max-width:100%}
.about{display:grid;grid-template-columns:max-content 1fr;gap:.15rem 1rem;margin:.2rem 0;font-size:.9rem}.about dt{color:var(--soft)}.about dd{margin:0;min-width:0}
.verdict{font-weight:600;white-space:nowrap}.verdict.met{color:var(--good)}.verdict.failed{color:var(--bad)}.verdict.open{color:var(--c4)}
.sections{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,480px),1fr));gap:1rem;grid-auto-flow:dense}
section{min-width:0;border:1px solid var(--grid);border-radius:8px;padding:.8rem 1rem}
section:has(.figures,.scene,.head,.cause,th:nth-child(5),li:nth-child(8)){grid-column:1/-1}section p{margin:.3rem 0 .6rem;max-width:60rem}
.figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,340px),1fr));gap:1rem}.figures>div{min-width:0}
figure{margin:0;max-width:620px;break-inside:avoid;position:relative}figcaption{font-weight:600;margin-bottom:.2rem}
svg{display:block;width:100%;height:auto;font:11px system-ui,sans-serif;fill:var(--ink)}
text{unicode-bidi:isolate}
.tick{font-size:10px;fill:var(--soft)}.mid{text-anchor:middle}.end{text-anchor:end}
.grid{stroke:var(--grid);fill:none;stroke-width:.7}.line{fill:none;stroke-width:1.8}
.limit{stroke:var(--ink);stroke-width:1.4;fill:none}.l0{stroke-dasharray:1 3}.l1{stroke-dasharray:9 3 1 3}.l2{stroke-dasharray:14 4}
.error{stroke:var(--ink);fill:none}
.s0{--c:var(--c0)}.s1{--c:var(--c1)}.s2{--c:var(--c2)}.s3{--c:var(--c3)}.s4{--c:var(--c4)}
.bar{fill:var(--c,var(--c0))}
.dots{fill:none;stroke:var(--c);stroke-width:2.8;stroke-linecap:round;stroke-opacity:.7}
.line,.error.s0,.error.s1,.error.s2,.error.s3,.error.s4{stroke:var(--c)}.band{fill:var(--c);fill-opacity:.22;stroke:var(--c);stroke-width:.5}
.d1{stroke-dasharray:7 3}.d2{stroke-dasharray:2 2}.d3{stroke-dasharray:8 2 2 2}.d4{stroke-dasharray:12 4}
.mark{fill:var(--c);stroke:var(--paper);stroke-width:.8}.mark.m4{fill:none;stroke:var(--c);stroke-width:2}
.cells{image-rendering:pixelated}.edge{fill:none;stroke:var(--soft);stroke-width:.7}
.cursor{fill:none;stroke:var(--ink);stroke-width:1.2}.window{fill:var(--c0);fill-opacity:.12;stroke:var(--c0)}
.legend{list-style:none;margin:.2rem 0;padding:0;display:flex;flex-wrap:wrap;gap:.1rem 1rem;font-size:.85rem}
.legend li{min-width:0}.key{display:inline-block;width:28px;height:12px;vertical-align:middle}
button,select,input{font:inherit;color:inherit}
button{background:var(--paper);border:1px solid var(--soft);border-radius:5px;padding:0 .5rem;min-width:1.8rem;min-height:1.6rem;cursor:pointer}
button:hover{background:var(--grid)}:focus-visible{outline:2px solid var(--c0);outline-offset:2px}
.legend button{border-color:transparent;background:none;padding:0 .2rem;font-size:inherit;text-align:left}.legend button[aria-pressed=false]{text-decoration:line-through;color:var(--soft)}.legend button[aria-pressed=false] svg{opacity:.3}
.tools{display:flex;gap:.3rem;align-items:center;font-size:.85rem}
.option[hidden],[hidden]{display:none}
.choice label{display:inline-block;margin-bottom:.4rem}
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:.9rem;font-variant-numeric:tabular-nums}
th,td{padding:.2rem .6rem;border-bottom:1px solid var(--grid);text-align:right}thead th{color:var(--soft);font-weight:600}
th,td{overflow-wrap:normal}td{white-space:nowrap}
th:first-child,td:first-child{text-align:left;min-width:5rem;white-space:normal;overflow-wrap:anywhere}
.cause{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,340px),1fr));gap:0 1rem}.cause h3{grid-column:1/-1;margin:.3rem 0}.cause ul{margin:0}.figures>.cause:only-child{grid-column:1/-1}
.verdicts th:first-child,.verdicts td:first-child{min-width:0;white-space:nowrap}.verdicts td.where{color:var(--soft);font-size:.8rem;border:0;white-space:normal;padding-top:0;max-width:24rem}.verdicts th:nth-child(2),.verdicts td:nth-child(2){min-width:9rem;text-align:left;white-space:normal;overflow-wrap:anywhere}
.use{background:linear-gradient(var(--c,var(--c0)),var(--c,var(--c0))) no-repeat 0 100%/var(--p) 4px}.over{--c:var(--bad)}
section .head{border:0;padding:0;margin:0;background:none}
.matrix td{background:color-mix(in srgb,var(--c0) var(--p,0%),transparent)}.matrix{font-size:.8rem}.matrix th:first-child{min-width:8rem;font-weight:400}
select{max-width:100%;background:var(--paper);border:1px solid var(--soft);border-radius:5px;padding:.1rem .3rem}
pre{white-space:pre-wrap;font-size:.85rem}output{display:block;min-height:1.4em;flex:1;min-width:0;font-size:.85rem;color:var(--soft)}
details{margin:1rem 0}summary{cursor:pointer}
.scene{display:grid;grid-template-columns:minmax(0,1fr) 17rem;gap:1rem}@media(max-width:56rem){.scene{grid-template-columns:minmax(0,1fr)}}
.scene canvas{display:block;width:100%;height:min(34rem,110vw);border:1px solid var(--grid);border-radius:8px;background:var(--card);cursor:grab;touch-action:pan-y}
.panel{display:flex;flex-direction:column;gap:.5rem;font-size:.9rem;min-width:0}.panel label{display:block}.panel select,.panel input[type=range]{width:100%;box-sizing:border-box;margin:0}
.panel .boxes{display:flex;flex-wrap:wrap;gap:.1rem .8rem}.panel table{font-size:.8rem;width:100%}.panel td,.panel th{padding:.1rem .2rem}.panel th:first-child,.panel td:first-child{min-width:0;overflow-wrap:normal;white-space:nowrap}.panel output{color:var(--ink);min-height:0;flex:none}
@media(max-width:30rem){body{padding:.6rem}.head,section{padding:.6rem .7rem}th,td{padding:.2rem .35rem}.about{grid-template-columns:1fr}.about dd{margin-bottom:.3rem}}
.flat{display:none}
@media (prefers-color-scheme:dark){:root{--ink:#e9ecf1;--soft:#a9b2bf;--paper:#13161b;--card:#1a1e25;--grid:#343a44;--c0:#56b4e9;--c1:#f08a3c;--c2:#35c79b;--c3:#dd92bd;--c4:#e0c341;--bad:#ff8a80;--good:#5fd39c}}
@page{margin:14mm 12mm 16mm;@bottom-right{content:counter(page) " / " counter(pages);font:9pt system-ui,sans-serif}}
@media print{:root{--ink:#000;--soft:#333;--paper:#fff;--card:#fff;--grid:#ccc;--c0:#0072b2;--c1:#c24f00;--c2:#007a59;--c3:#a0437c;--c4:#806600;--bad:#b3261e;--good:#0b6b45}
body{font-size:9pt;padding:0;max-width:none}h1{font-size:15pt}.figures{grid-template-columns:1fr 1fr 1fr;gap:.4rem .8rem}output,.choice label,.tools,.scene,details:not([open]){display:none}.wide{overflow:visible}.flat{display:block}.sections{display:block}section{border:0;padding:.3rem 0}.head{padding:.2rem .6rem;margin:0}
table{font-size:7pt;line-height:1.2}th,td{padding:0 .4rem}
.choice{display:grid;grid-template-columns:repeat(5,1fr);gap:.3rem .8rem}.option,.option[hidden]{display:block;min-width:0;break-inside:avoid}.option:has(.figures,table){grid-column:1/-1}.option[hidden]:has(.figures){display:none}.legend{font-size:6pt;line-height:1.2;gap:0 .5rem}.key{width:20px;height:9px}.answer{font-size:11pt;margin:.2rem 0}figcaption{font-size:8pt}h2{margin:.2rem 0;font-size:11pt}section p{margin:.1rem 0}h2,section>p{break-after:avoid}svg,.bar,.band,.cells,.use{print-color-adjust:exact;-webkit-print-color-adjust:exact}}
)";

}  // namespace qerr::page
