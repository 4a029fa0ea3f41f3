/** The request of this answer as a program sends it. */
import { useSignal } from "@preact/signals";
import { key } from "../api/key";
import { answer } from "../state/live";
import { wishes } from "../state/request";
import { give } from "../state/tidy";

const LANGUAGES = { curl, Python: python, JavaScript: javascript } as const;
type Language = keyof typeof LANGUAGES;

export function Request() {
  const language = useSignal<Language>("curl");
  const said = useSignal("");
  const now = answer.value;
  if (!now) return <p class="hint">There is no answer yet.</p>;
  const request = { mesh: now.mesh.document.id, sketch: now.reading.document.id, ...wishes.value };
  const text = LANGUAGES[language.value](location.origin, JSON.stringify(request, null, 1).replaceAll(/\n\s*/g, " "));
  const copy = async () => {
    // The sketch is not deleted after the next stroke: whoever has the request uses it.
    give(now.reading.document.id);
    said.value = await navigator.clipboard.writeText(text).then(
      () => "Copied",
      () => "Select the text and copy it",
    );
  };
  return (
    <>
      <div class="group" role="group" aria-label="Language">
        {Object.keys(LANGUAGES).map((name) => (
          <button
            key={name}
            type="button"
            aria-pressed={language.value === name}
            onClick={() => {
              language.value = name as Language;
              said.value = "";
            }}
          >
            {name}
          </button>
        ))}
        <button type="button" class="copy" onClick={copy}>
          Copy
        </button>
        <span class="said" role="status">
          {said.value}
        </span>
      </div>
      {/* biome-ignore lint/a11y/noNoninteractiveTabindex: it scrolls. */}
      <pre tabIndex={0}>{text}</pre>
    </>
  );
}

/** Within single quotes of a shell. */
const quoted = (text: string) => `'${text.replaceAll("'", `'\\''`)}'`;

// The key itself is written into nothing that is copied.

function curl(origin: string, request: string): string {
  const withKey = key.value ? ` -H "Authorization: Bearer $SKETCHMATCH_KEY"` : "";
  return `MATCH=$(curl -s${withKey} -H 'Prefer: wait=60' -H 'Content-Type: application/json' \\
  -d ${quoted(request)} \\
  ${origin}/v1/matches)
RESULT=$(echo "$MATCH" | grep -o '/v1/matches/[^"]*/result')
curl -s${withKey} "${origin}$RESULT" > result.json`;
}

function python(origin: string, request: string): string {
  const [imports, withKey] = key.value
    ? ["import json\nimport os", `headers["Authorization"] = "Bearer " + os.environ["SKETCHMATCH_KEY"]\n`]
    : ["import json", ""];
  return `${imports}
from urllib.request import Request, urlopen

SERVER = "${origin}"
request = json.loads(r'''${request}''')
headers = {"Content-Type": "application/json", "Prefer": "wait=60"}
${withKey}with urlopen(Request(SERVER + "/v1/matches", json.dumps(request).encode(), headers)) as answer:
    match = json.load(answer)
with urlopen(Request(SERVER + match["links"]["result"], headers=headers)) as answer:
    result = json.load(answer)
print(result["rating"], result["correspondences"][0])`;
}

function javascript(origin: string, request: string): string {
  const withKey = key.value ? `headers.authorization = "Bearer " + process.env.SKETCHMATCH_KEY;\n` : "";
  return `const server = "${origin}";
const request = ${request};
const headers = { "content-type": "application/json", prefer: "wait=60" };
${withKey}const asked = await fetch(server + "/v1/matches", { method: "POST", headers, body: JSON.stringify(request) });
const match = await asked.json();
const result = await (await fetch(server + match.links.result, { headers })).json();
console.log(result.rating, result.correspondences[0]);`;
}
