-- What an editor makes of the language server: Neovim, without a screen, types, asks and runs.
--     LOSTMOTION=program PART=file nvim --headless -n -u NONE -c 'luafile .ci/editor.lua'
local patience = 300000

local function say(text)
  io.stdout:write(text .. "\n")
end
local function fail(what)
  say("neovim: " .. what)
  vim.cmd("cquit 1")
end
local function waits(what, condition)
  if not vim.wait(patience, condition, 50) then
    fail(what .. " does not come; findings: " .. vim.inspect(vim.diagnostic.get(0)))
  end
end
local function errors()
  return vim.diagnostic.get(0, { severity = vim.diagnostic.severity.ERROR })
end

-- The editor tells of changes a moment after they were made.
local function typed()
  vim.wait(1000)
end

local function check()
  vim.cmd("edit " .. vim.fn.fnameescape(vim.env.PART))
  local id = vim.lsp.start_client({ name = "lostmotion", cmd = { vim.env.LOSTMOTION, "lsp", "-m", "vmc3" }, root_dir = vim.fn.getcwd() })
  vim.lsp.buf_attach_client(0, id)
  local client = vim.lsp.get_client_by_id(id)
  waits("the finding in line 3", function()
    return #errors() > 0 and errors()[1].lnum == 2
  end)
  -- The line is mended by typing.
  vim.api.nvim_buf_set_lines(0, 2, 3, false, { "G1 X5 F500" })
  waits("a text without errors", function()
    return #errors() == 0
  end)
  local here = { uri = vim.uri_from_bufnr(0) }
  local function ask(method, params)
    local answer = client.request_sync(method, params, patience, 0)
    if not answer or answer.err then
      fail(method .. ": " .. vim.inspect(answer))
    end
    return answer.result
  end
  local hover = ask("textDocument/hover", { textDocument = here, position = { line = 2, character = 1 } })
  if not (hover and hover.contents.value:find("line 3")) then
    fail("hover: " .. vim.inspect(hover))
  end
  -- Formatting is applied by the editor: numbers get their form, the program stays.
  vim.api.nvim_buf_set_lines(0, 2, 3, false, { "g1   x5.000 f500" })
  typed()
  local edits = ask("textDocument/formatting", { textDocument = here, options = { tabSize = 2, insertSpaces = true } })
  vim.lsp.util.apply_text_edits(edits, 0, client.offset_encoding)
  local line = vim.api.nvim_buf_get_lines(0, 2, 3, false)[1]
  if not line:find("^G1 X5") then
    fail("formatted line: " .. line)
  end
  typed()
  local lens = ask("textDocument/codeLens", { textDocument = here })[1]
  ask("workspace/executeCommand", { command = lens.command.command, arguments = lens.command.arguments })
  local hints
  waits("the error behind a line", function()
    hints = ask("textDocument/inlayHint", { textDocument = here, range = { start = { line = 0, character = 0 }, ["end"] = { line = 10000, character = 0 } } })
    return #hints > 0
  end)
  say(#hints .. " lines with their errors")
  vim.lsp.stop_client(id)
  vim.cmd("qall!")
end

-- An error of the script must not leave the editor waiting.
local good, wrong = pcall(check)
if not good then
  fail(tostring(wrong))
end
