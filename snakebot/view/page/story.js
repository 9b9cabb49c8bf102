/* Several runs of one undertaking: what is going on, the verdict so far, the runs that were made, what comes next. */
import { $ } from "./common.js";

const line = (tag, ...words) => {
  const element = document.createElement(tag);
  element.append(...words);
  return element;
};

export class Story {
  show(story) {
    $("story-box").hidden = false;
    $("story-now").textContent = story.now || "";
    $("verdict").textContent = story.verdict || "No verdict yet.";
    const causes = story.causes || [];
    $("causes").hidden = !causes.length;
    $("causes").tBodies[0].replaceChildren(...causes.map((cause) => {
      const probability = line("td", `${Math.round(100 * cause.probability)} %`);
      probability.className = "n";
      return line("tr", line("td", cause.name), probability, line("td", cause.parameters.join(", ")));
    }));
    $("story-runs").replaceChildren(...(story.runs || []).map((run) => line("li", line("code", run.command), ` ${run.how}`)));
    $("story-next").textContent = story.next || "";
  }
}
