#include "report/page/page.hpp"

#include "report/page/markup.hpp"

namespace qerr::page {

std::string table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows) {
  std::string out = "<div class=\"wide\"><table><thead><tr>";
  for (const std::string& cell : header) out += "<th scope=\"col\">" + escaped_markup(cell) + "</th>";
  out += "</tr></thead><tbody>\n";
  for (const auto& row : rows) {
    out += "<tr>";
    for (const std::string& cell : row) out += "<td>" + name_markup(cell) + "</td>";
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
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
      "</style></head><body>\n<h1>" + name_markup(page.title) + "</h1>\n<p class=\"answer\">" +
      escaped_markup(page.answer) + "</p>\n" + page.about;
  for (const Section& s : page.sections)
    out += "<section><h2>" + escaped_markup(s.heading) + "</h2>\n" + s.body + "</section>\n";
  if (!page.warnings.empty()) {
    out += "<section><h2>Warnings and assumptions</h2><ul>\n";
    for (const std::string& w : page.warnings) out += "<li>" + escaped_markup(w) + "</li>\n";
    out += "</ul></section>\n";
  }
  if (!page.spec_text.empty())
    out += "<details><summary>Spec " + name_markup(page.spec_file) + "</summary><pre>" +
           escaped_markup(page.spec_text) + "</pre></details>\n";
  return out + "<script>" + std::string(script) + "</script></body></html>\n";
}

std::size_t bytes_left(const Page& page) {
  // Some texts are given without the entities and elements around them: a reserve of 25 kB.
  constexpr std::size_t most = 275000, fewest = 40000;
  std::size_t taken =
      style_sheet.size() + script.size() + page.answer.size() + page.about.size() + page.spec_text.size();
  for (const Section& s : page.sections) taken += s.heading.size() + s.body.size();
  for (const std::string& w : page.warnings) taken += w.size();
  return most > taken + fewest ? most - taken : fewest;
}

const std::string_view style_sheet = R"(
:root{--ink:#1b1b1b;--soft:#595959;--paper:#fff;--grid:#dcdcdc;--c0:#0072b2;--c1:#d55e00;--c2:#009e73;--c3:#a0437c;--c4:#806600}
body{margin:0 auto;max-width:1200px;padding:1rem;color:var(--ink);background:var(--paper);font:16px/1.45 system-ui,sans-serif;overflow-wrap:anywhere}
h1{font-size:1.5rem;margin:.2rem 0}h2{font-size:1.15rem;margin:1.6rem 0 .4rem;break-after:avoid}
.answer{font-size:1.15rem}.about{display:grid;grid-template-columns:max-content 1fr;gap:.15rem 1rem;margin:.6rem 0;font-size:.9rem}.about dt{color:var(--soft)}.about dd{margin:0;min-width:0}@media(max-width:30rem){.about{grid-template-columns:1fr}}
.figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,340px),1fr));gap:1rem}
figure{margin:0;max-width:620px;break-inside:avoid}figcaption{font-weight:600}
svg{display:block;width:100%;height:auto;font:11px system-ui,sans-serif;fill:var(--ink)}
text{unicode-bidi:isolate}
.tick{font-size:10px;fill:var(--soft)}.mid{text-anchor:middle}.end{text-anchor:end}
.grid{stroke:var(--grid);fill:none;stroke-width:.7}.line{fill:none;stroke-width:1.8}
.limit{stroke:var(--ink);stroke-width:1.4;fill:none}.l0{stroke-dasharray:1 3}.l1{stroke-dasharray:9 3 1 3}.l2{stroke-dasharray:14 4}
.error{stroke:var(--ink);fill:none}.bar{fill:var(--c0)}
.s0{--c:var(--c0)}.s1{--c:var(--c1)}.s2{--c:var(--c2)}.s3{--c:var(--c3)}.s4{--c:var(--c4)}
.line,.error.s0,.error.s1,.error.s2,.error.s3,.error.s4{stroke:var(--c)}.band{fill:var(--c);fill-opacity:.22;stroke:var(--c);stroke-width:.5}
.d1{stroke-dasharray:7 3}.d2{stroke-dasharray:2 2}.d3{stroke-dasharray:8 2 2 2}.d4{stroke-dasharray:12 4}
.mark{fill:var(--c);stroke:var(--paper);stroke-width:.8}.mark.m4{fill:none;stroke:var(--c);stroke-width:2}
.cells{image-rendering:pixelated}.edge{fill:none;stroke:var(--soft);stroke-width:.7}
.legend{list-style:none;margin:.2rem 0;padding:0;display:flex;flex-wrap:wrap;gap:.1rem 1rem;font-size:.85rem}
.legend li{min-width:0}.key{display:inline-block;width:28px;height:12px;vertical-align:middle}
.option[hidden]{display:none}
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:.9rem;font-variant-numeric:tabular-nums}
th,td{padding:.15rem .6rem;border-bottom:1px solid var(--grid);text-align:right}
th,td{overflow-wrap:normal}td{white-space:nowrap}
th:first-child,td:first-child{text-align:left;min-width:11rem;white-space:normal;overflow-wrap:anywhere}
select{font:inherit;max-width:100%;color:inherit;background:var(--paper)}
pre{white-space:pre-wrap;font-size:.85rem}output{display:block;min-height:1.4em;font-size:.85rem;color:var(--soft)}
@media (prefers-color-scheme:dark){:root{--ink:#ececec;--soft:#b5b5b5;--paper:#15171a;--grid:#3a3d42;--c0:#56b4e9;--c1:#f08a3c;--c2:#35c79b;--c3:#dd92bd;--c4:#e0c341}}
@media print{:root{--ink:#000;--soft:#333;--paper:#fff;--grid:#ccc;--c0:#0072b2;--c1:#d55e00;--c2:#009e73;--c3:#a0437c;--c4:#806600}
body{font-size:10pt;padding:0}.figures{grid-template-columns:1fr 1fr}output,.choice label{display:none}.wide{overflow:visible}
.choice{display:grid;grid-template-columns:1fr 1fr;gap:.5rem 1rem}.option,.option[hidden]{display:block;min-width:0;break-inside:avoid}.option:has(.figures,table){grid-column:1/-1}h2,section>p{break-after:avoid}svg,.bar,.band,.cells{print-color-adjust:exact;-webkit-print-color-adjust:exact}}
)";

const std::string_view script = R"(
document.querySelectorAll('.choice').forEach(function(box){
var list=box.querySelector('select'),parts=Array.from(box.querySelectorAll('.option'));
if(!list)return;
box.querySelector('label').hidden=false;
function show(){parts.forEach(function(p,i){p.hidden=i!==list.selectedIndex})}
list.addEventListener('change',show);show()});
function value(text,unit){
var v=Number(text),p=0;
if(unit===''||v===0||/^(%|deg|1)/.test(unit))return Number(v.toPrecision(4))+(unit?' '+unit:'');
p=Math.min(3,Math.max(-4,Math.floor(Math.log10(Math.abs(v)*1.0000001)/3)));
return Number((v/Math.pow(1000,p)).toPrecision(4))+' '+['p','n','u','m','','k','M','G'][p+4]+unit}
document.querySelectorAll('figure').forEach(function(f){
var svg=f.querySelector('svg[data-units]'),lines=f.querySelectorAll('[data-points]'),marks=f.querySelectorAll('[data-x]');
if(!svg||lines.length+marks.length===0)return;
var units=svg.getAttribute('data-units').split('|'),says=document.createElement('output');
f.insertBefore(says,svg.nextSibling);
svg.addEventListener('pointermove',function(e){
var best='',near=900;
function look(item,px,py,x,y){
var map=svg.getScreenCTM(),dx=px*map.a+map.e-e.clientX,dy=py*map.d+map.f-e.clientY,d=dx*dx+dy*dy;
if(near>d){near=d;best='\u2068'+item.parentNode.getAttribute('data-series')+'\u2069: '+value(x,units[0])+', '+value(y,units[1])}}
lines.forEach(function(l){
var at=l.getAttribute('d').slice(1).split(/[ML]/),data=l.getAttribute('data-points').split(' ');
at.forEach(function(t,i){var a=t.split(' '),b=data[i].split(',');look(l,a[0],a[1],b[0],b[1])})});
marks.forEach(function(m){
var a=m.getBBox();look(m,a.x+a.width/2,a.y+a.height/2,m.getAttribute('data-x'),m.getAttribute('data-y'))});
says.textContent=best})});
function pixels(item,use){
var p=new Image();
p.onload=function(){
var c=document.createElement('canvas'),t=c.getContext('2d',{willReadFrequently:true});
c.width=p.width;c.height=p.height;t.drawImage(p,0,0);use(t.getImageData(0,0,c.width,c.height))};
p.setAttribute('src',item.getAttribute('href'))}
document.querySelectorAll('image[data-span]').forEach(function(m){
var svg=m.ownerSVGElement,says=document.createElement('output'),steps={},grid=null;
svg.parentNode.appendChild(says);
function number(name){return Number(m.getAttribute(name))}
function colour(d,i){return d[4*i]+','+d[4*i+1]+','+d[4*i+2]}
pixels(svg.querySelector('image.scale'),function(b){
Array.from({length:b.height}).forEach(function(_,i){steps[colour(b.data,i)]=1-i/(b.height-1)})});
pixels(m,function(g){grid=g});
svg.addEventListener('pointermove',function(e){
var map=svg.getScreenCTM(),s=m.getAttribute('data-span').split(' ').map(Number),units=svg.getAttribute('data-units').split('|');
var u=((e.clientX-map.e)/map.a-number('x'))/number('width'),v=((e.clientY-map.f)/map.d-number('y'))/number('height');
says.textContent='';
if(!grid||0>u||0>v||u>=1||v>=1)return;
var i=Math.floor(v*grid.height)*grid.width+Math.floor(u*grid.width),from=number('data-from');
if(grid.data[4*i+3]===0)return;
says.textContent=value(s[0]+u*(s[1]-s[0]),units[0])+', '+value(s[3]-v*(s[3]-s[2]),units[1])+': '+value(from+steps[colour(grid.data,i)]*(number('data-to')-from),m.getAttribute('data-unit'))})});
)";

}  // namespace qerr::page
